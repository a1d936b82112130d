"""A report as one HTML file that needs nothing else: no server, no network, no library."""

from spatial_relations_ros.visualization.report.page import report_html, write_report

__all__ = ['report_html', 'write_report']
