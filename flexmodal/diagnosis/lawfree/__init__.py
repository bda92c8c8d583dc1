"""Where something is missing and of what class it is, without a law for it."""

from flexmodal.diagnosis.lawfree.curve import Class as Class
from flexmodal.diagnosis.lawfree.curve import Curve as Curve
from flexmodal.diagnosis.lawfree.curve import classes_of as classes_of
from flexmodal.diagnosis.lawfree.curve import curve_of as curve_of
from flexmodal.diagnosis.lawfree.look import LawFree as LawFree
from flexmodal.diagnosis.lawfree.look import Sighting as Sighting
from flexmodal.diagnosis.lawfree.look import law_free as law_free
