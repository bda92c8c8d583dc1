"""Which ports can do what which effects do."""

import pytest

from flexmodal.diagnosis.lawfree.effects_at import PORT_OF, WIDE, holds


@pytest.mark.parametrize("port", ["attached", "ground", "across"])
def test_what_is_not_alike_every_way_holds_what_a_mass_does(port):
    """And more than its narrow law: a load on a rope has to move up and down alone."""
    mass = (PORT_OF["added_mass"], "link_3")
    assert holds((port, "link_3"), mass)
    assert not holds((port, "link_2"), mass)
    assert not holds(mass, (port, "link_3"))
    assert port in WIDE
