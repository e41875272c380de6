"""Updates finite-element models of structures to vibration tests, and finds the physics that the models miss.

The names are those of the command ``retune``: what ``retune update model.yaml test.yaml --json`` prints is
``retune.update(model, test).to_dict()``. Values are SI unless a name or a unit says otherwise; frequencies are in Hz.

>>> import retune
>>> model = retune.Model.from_text('''
... retune: 1
... name: mass on a spring
... parameters: {k: {value: 100 N/m, bounds: [10 N/m, 1000 N/m]}}
... nodes: {a: [0, 0, 0]}
... active_dofs: [uz]
... springs: {support: {node: a, k: {uz: k}}}
... masses: {block: {node: a, mass: 1 kg}}
... ''')
>>> test = retune.Test.from_arrays([2.0], frequency_sd=0.01, name="one mode")
>>> result = retune.update(model, test)
>>> round(result["k"].after, 2)  # k = m (2 pi f)^2
157.91
"""

from ._catalogue import catalogue
from ._core import __version__
from ._effect import Effect, Location, Node, Part, Size, Structure
from ._element import Element, Property, Sample
from ._errors import Problem, RetuneError, RetuneWarning
from ._external import ParametricModel
from ._fault import At, Bench, Fault
from ._found import Diagnosis, Hypothesis, Learning
from ._frfs import Channel, Frfs, read_frfs
from ._model import MassProperties, Matrices, Model, Modes, Parameter
from ._objective import Objective, Optimum, Search
from ._optimizer import Optimizer, Run, SearchEnded
from ._residual import Measured, Predicted, Residual
from ._results import (
    Comparison,
    Identification,
    ParameterEstimate,
    Pair,
    Plan,
    Posterior,
    Report,
    Result,
    TwinResult,
    UpdateResult,
)
from ._strategy import Best1Bin
from ._test import Sensor, Test, TestMode
from ._verbs import compare, diagnose, identify, learn, pretest, report, sample, twin, update

__all__ = [
    "At",
    "Bench",
    "Best1Bin",
    "Channel",
    "Comparison",
    "Diagnosis",
    "Effect",
    "Element",
    "Fault",
    "Frfs",
    "Hypothesis",
    "Identification",
    "Learning",
    "Location",
    "MassProperties",
    "Matrices",
    "Measured",
    "Model",
    "Modes",
    "Node",
    "Objective",
    "Optimizer",
    "Optimum",
    "Pair",
    "Parameter",
    "ParameterEstimate",
    "ParametricModel",
    "Part",
    "Plan",
    "Posterior",
    "Predicted",
    "Problem",
    "Property",
    "Report",
    "Residual",
    "Result",
    "RetuneError",
    "RetuneWarning",
    "Run",
    "Sample",
    "Search",
    "SearchEnded",
    "Sensor",
    "Size",
    "Structure",
    "Test",
    "TestMode",
    "TwinResult",
    "UpdateResult",
    "__version__",
    "catalogue",
    "compare",
    "diagnose",
    "identify",
    "learn",
    "pretest",
    "read_frfs",
    "report",
    "sample",
    "twin",
    "update",
]
