"""A report as one HTML file that needs nothing else: no server, no network, no library."""

from spatial_relations_ros.visualization.report.page import report_html, write_report
from spatial_relations_ros.visualization.report.sections import ReportSection

__all__ = ['ReportSection', 'report_html', 'write_report']
