"""Shots into ballistic gelatin: scenes, runs, results, FMUs and sweeps.

>>> import ballistic_gel as bg
>>> shot = bg.run(bg.Scene.new_shot("bb", speed=180))
>>> shot.summary["rest_depth"]  # m
>>> shot.plot.wound_profile()
"""

from .binary import find_binary
from .commands import Calibration, calibrate, figures, projectiles, scenes
from .errors import CrashWarning, DoubtWarning, FitWarning, GelfmuError, ShotError
from .fitting import GelFit, fit_gel
from .fmu import FmuInstance, pack, simulate
from .frames import Frame, FrameSequence
from .levels import level_errors
from .reduction import Reduction, reduce_model
from .running import run
from .samplers import Grid, LatinHypercube, LogNormal, Normal, Sobol, Uniform
from .scene import Scene, SceneCheck
from .shot import Shot
from .study import Study
from .sweeping import run_scenes, sweep
from .trade import TradeCurve, error_cost, option_costs
from .validation import Validation, measured_shots, validate

__all__ = [
    "Calibration",
    "CrashWarning",
    "DoubtWarning",
    "FitWarning",
    "FmuInstance",
    "Frame",
    "FrameSequence",
    "GelFit",
    "GelfmuError",
    "Grid",
    "LatinHypercube",
    "LogNormal",
    "Normal",
    "Reduction",
    "Scene",
    "SceneCheck",
    "Shot",
    "ShotError",
    "Sobol",
    "Study",
    "TradeCurve",
    "Uniform",
    "Validation",
    "calibrate",
    "error_cost",
    "figures",
    "find_binary",
    "fit_gel",
    "level_errors",
    "measured_shots",
    "option_costs",
    "pack",
    "projectiles",
    "reduce_model",
    "run",
    "run_scenes",
    "scenes",
    "simulate",
    "sweep",
    "validate",
]
