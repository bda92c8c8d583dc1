"""What a diagnosis was made from: versions, hashes of the inputs, seed."""

from __future__ import annotations

import hashlib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from flexmodal.campaign import Campaign
from flexmodal.model import Robot

PACKAGES = ("flexmodal", "pin", "numpy", "scipy")


def provenance(campaign: Campaign, robot: Robot, seed: int) -> dict[str, str]:
    """Versions, SHA-256 of every input file, and the seed.

    Args:
        campaign: its files count where it was read from a folder.
        robot: its URDF counts.
        seed: of what is drawn.
    """
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    if campaign.path is not None:
        for name in ("campaign.toml", "frf.uff", "time.uff", "modes.csv"):
            if (campaign.path / name).is_file():
                found[name] = digest(campaign.path / name)
    found["URDF"] = hashlib.sha256(robot.urdf.text.encode()).hexdigest()
    found["seed"] = str(seed)
    return found


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
