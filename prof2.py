import sys; sys.path.insert(0,'/work/wt/measured')
import numpy as np, cProfile, pstats
from tests.ema import test_coverage as t
from tests.ema.truth import real_modes
from flexmodal.ema import estimate, Choices
truth = real_modes([20.0, 40.0], [0.04, 0.05], np.array([[1.0, 1.2]]))
dr=t._draws(truth, np.linspace(5, 60, 110), 7, known=True,count=20)
def f():
    for d in dr: estimate(d, "lscf", Choices(highest_order=12))
cProfile.run('f()','/tmp/measured_scratch/pr'); pstats.Stats('/tmp/measured_scratch/pr').sort_stats('tottime').print_stats(14)
pstats.Stats('/tmp/measured_scratch/pr').sort_stats('cumtime').print_stats(30)
