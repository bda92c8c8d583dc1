"""Is a hammer test sound? What is wrong with it, on what evidence, what it costs, and what to do."""

from flexmodal.soundness.check import check_soundness as check_soundness
from flexmodal.soundness.finding import Finding as Finding
from flexmodal.soundness.finding import FindingKind as FindingKind
from flexmodal.soundness.low_corner import without_coupling as without_coupling
