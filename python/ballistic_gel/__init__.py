"""Shots into ballistic gelatin: scenes, runs, results, FMUs and sweeps.

>>> import ballistic_gel as bg
>>> shot = bg.run(bg.Scene.new_shot("bb", speed=180))
>>> shot.summary["rest_depth"]  # m
>>> shot.plot.wound_profile()
"""

from .binary import find_binary
from .commands import Calibration, Validation, calibrate, projectiles, scenes, validate
from .errors import CrashWarning, DoubtWarning, FitWarning, GelfmuError, ShotError
from .fmu import FmuInstance, pack, simulate
from .frames import Frame, FrameSequence
from .levels import level_errors
from .running import run
from .samplers import Grid, LatinHypercube, LogNormal, Normal, Sobol, Uniform
from .scene import Scene, SceneCheck
from .shot import Shot
from .study import Study
from .sweeping import sweep

__all__ = [
    "Calibration",
    "CrashWarning",
    "DoubtWarning",
    "FitWarning",
    "FmuInstance",
    "Frame",
    "FrameSequence",
    "GelfmuError",
    "Grid",
    "LatinHypercube",
    "LogNormal",
    "Normal",
    "Scene",
    "SceneCheck",
    "Shot",
    "ShotError",
    "Sobol",
    "Study",
    "Uniform",
    "Validation",
    "calibrate",
    "find_binary",
    "level_errors",
    "pack",
    "projectiles",
    "run",
    "scenes",
    "simulate",
    "sweep",
    "validate",
]
