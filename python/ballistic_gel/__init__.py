"""Shots into ballistic gelatin: scenes, runs, results, FMUs and sweeps.

>>> import ballistic_gel as bg
>>> shot = bg.run(bg.Scene.new_shot("bb", speed=180))
>>> shot.summary["rest_depth"]  # m
>>> shot.plot.wound_profile()
"""

from .binary import find_binary
from .commands import Calibration, Validation, calibrate, projectiles, scenes, validate
from .errors import DoubtWarning, GelfmuError, ShotError
from .fmu import FmuInstance, pack, simulate
from .frames import Frame, FrameSequence
from .running import run
from .scene import Scene, SceneCheck
from .shot import Shot

__all__ = [
    "Calibration",
    "DoubtWarning",
    "FmuInstance",
    "Frame",
    "FrameSequence",
    "GelfmuError",
    "Scene",
    "SceneCheck",
    "Shot",
    "ShotError",
    "Validation",
    "calibrate",
    "find_binary",
    "pack",
    "projectiles",
    "run",
    "scenes",
    "simulate",
    "validate",
]
