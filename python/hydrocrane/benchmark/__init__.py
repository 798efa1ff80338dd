"""Benchmark of crane-tip control: tasks, conditions, measures, the tuning of gains, and operators who load logs."""

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
from hydrocrane.benchmark.loading import Cycle, LogTask, loading_cycle, log_task, tune_operator, tuned_operator
from hydrocrane.benchmark.operator import INTERFACES, Operator, Waypoint
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
    "INTERFACES",
    "LOGS",
    "MACHINE",
    "SHORT",
    "STANDING",
    "START",
    "VARIANTS",
    "Benchmark",
    "Case",
    "Condition",
    "Cycle",
    "LogTask",
    "Operator",
    "Result",
    "Waypoint",
    "all_cases",
    "benchmark",
    "drawn_cases",
    "friction_overrides",
    "loading_cycle",
    "log_task",
    "motion_of",
    "quick_cases",
    "random_lines",
    "run_case",
    "scenario_of",
    "tune_operator",
    "tuned_operator",
]
