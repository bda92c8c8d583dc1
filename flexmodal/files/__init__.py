"""Writing files and folders whole or not at all, by one process at a time, never unasked; data that ship."""

from flexmodal.files.refusal import refuse_file as refuse_file
from flexmodal.files.refusal import refuse_folder as refuse_folder
from flexmodal.files.shipped import catalogue_folder as catalogue_folder
from flexmodal.files.shipped import path_or_shipped as path_or_shipped
from flexmodal.files.shipped import shipped as shipped
from flexmodal.files.stage import claimed as claimed
from flexmodal.files.stage import complete as complete
from flexmodal.files.whole import whole_file as whole_file
from flexmodal.files.whole import whole_folder as whole_folder
from flexmodal.files.whole import whole_set as whole_set
