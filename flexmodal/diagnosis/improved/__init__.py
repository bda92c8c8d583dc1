"""The improved robot as URDF and card."""
