"""A report as one HTML file that needs nothing else: no server, no network, no library."""

from spatial_relations_ros.visualization.report.content import pose_content, scene_content
from spatial_relations_ros.visualization.report.models import ModelStore
from spatial_relations_ros.visualization.report.page import page_part, report_html, write_report
from spatial_relations_ros.visualization.report.sections import ReportSection

__all__ = [
    'ModelStore',
    'ReportSection',
    'page_part',
    'pose_content',
    'report_html',
    'scene_content',
    'write_report',
]
