"""Named studies: what a thesis or paper has computed, computed again beside its printed numbers."""

from flexmodal.optimisation.studies.read import read_studies as read_studies
from flexmodal.optimisation.studies.read import shipped_studies as shipped_studies
from flexmodal.optimisation.studies.run import StudyResult as StudyResult
from flexmodal.optimisation.studies.run import run_study as run_study
from flexmodal.optimisation.studies.study import Study as Study
