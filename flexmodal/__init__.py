"""Receptance, modes and the best posture of flexible-joint robots.

The names below are imported when they are first used (SPEC 1 of the scientific Python ecosystem), so that
`import flexmodal` does not wait for Pinocchio.
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
