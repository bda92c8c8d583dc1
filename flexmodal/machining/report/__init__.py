"""Results as JSON objects, tables, files, pictures and pages."""

from flexmodal.machining.report.files import COMPARISON_COLUMNS as COMPARISON_COLUMNS
from flexmodal.machining.report.files import LOBES_COLUMNS as LOBES_COLUMNS
from flexmodal.machining.report.files import lobes_picture as lobes_picture
from flexmodal.machining.report.files import write_comparison_csv as write_comparison_csv
from flexmodal.machining.report.files import write_comparison_page as write_comparison_page
from flexmodal.machining.report.files import write_json as write_json
from flexmodal.machining.report.files import write_lobes_csv as write_lobes_csv
from flexmodal.machining.report.files import write_lobes_page as write_lobes_page
from flexmodal.machining.report.objects import comparison_object as comparison_object
from flexmodal.machining.report.objects import lobes_object as lobes_object
from flexmodal.machining.report.rows import BEST as BEST
from flexmodal.machining.report.rows import NUMBERS as NUMBERS
from flexmodal.machining.report.rows import POSTURES as POSTURES
from flexmodal.machining.report.rows import best_rows as best_rows
from flexmodal.machining.report.rows import hertz as hertz
from flexmodal.machining.report.rows import millimetres as millimetres
from flexmodal.machining.report.rows import numbers as numbers
from flexmodal.machining.report.rows import posture_rows as posture_rows
from flexmodal.machining.report.rows import stable_part as stable_part
