"""Benchmark of crane-tip control: tasks, conditions, measures, and the tuning of gains."""

from hydrocrane.benchmark.cases import (
    SHORT,
    STANDING,
    START,
    Case,
    Result,
    motion_of,
    quick_cases,
    run_case,
    scenario_of,
)
from hydrocrane.benchmark.conditions import FRICTION_KEYS, VARIANTS, Condition, friction_overrides
from hydrocrane.benchmark.random_tasks import random_lines
from hydrocrane.benchmark.suite import (
    CONTROLLERS,
    LOGS,
    MACHINE,
    Benchmark,
    all_cases,
    benchmark,
    drawn_cases,
)

__all__ = [
    "CONTROLLERS",
    "FRICTION_KEYS",
    "LOGS",
    "MACHINE",
    "SHORT",
    "STANDING",
    "START",
    "VARIANTS",
    "Benchmark",
    "Case",
    "Condition",
    "Result",
    "all_cases",
    "benchmark",
    "drawn_cases",
    "friction_overrides",
    "motion_of",
    "quick_cases",
    "random_lines",
    "run_case",
    "scenario_of",
]
