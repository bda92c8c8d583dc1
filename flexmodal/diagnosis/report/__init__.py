"""The report of a diagnosis: one page that needs no network."""

from flexmodal.diagnosis.report.page import write_report as write_report
