"""Holds and objectives as arrays and functions for the compiler, where a problem can be one."""

from flexmodal.optimisation.compiled.arm import arm_of as arm_of
from flexmodal.optimisation.compiled.arm import box_of as box_of
from flexmodal.optimisation.compiled.arrays import Arm as Arm
from flexmodal.optimisation.compiled.functions import COMPILATION as COMPILATION
from flexmodal.optimisation.compiled.functions import descents as descents
