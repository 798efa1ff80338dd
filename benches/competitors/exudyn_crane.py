"""Exudyn: the nearest crane it can express, rigid links in redundant coordinates and its simple hydraulic actuator.

Not the same model, so its tip error is that from its own tightest result. What differs is in DIFFERENCES.
"""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np

from benches.models import crane
from benches.problem import NotAvailable, Problem, Solution, clocked

DIFFERENCES = (
    "the bulk modulus of the oil is constant, that of 60 bar",
    "valves open and close at once: no spool dynamics; flow goes with the root of the pressure drop down to zero",
    "friction is linear, with the secant of the viscous part at 50 mm/s: no Stribeck curve, no bristles",
    "no leakage, no end stops, no pressure rise in the connectors",
    "the four-bar's rod pin is a mass of 0.1 kg on two rods; links turn in redundant coordinates with constraints",
)
STEPS = (5e-3, 2.5e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5)
REFERENCE_STEP = 2e-5
BULK_PRESSURE, FRICTION_SPEED, PIN_MASS = 60e5, 0.05, 0.1


class Model:
    """The mechanism with its actuators, ready to be run again and again."""

    def __init__(self, problem: Problem) -> None:
        if importlib.util.find_spec("exudyn") is None:
            raise NotAvailable("exudyn is not installed")
        import exudyn as exu
        from exudyn import itemInterface as items

        self.exu, self.items, self.problem = exu, items, problem
        self.numbers = crane.parameters(problem.crane)
        # Where points are when the run begins; links take their frames from there.
        self.chain = crane.Chain(list(problem.start[: crane.JOINTS]), self.numbers, crane.NUMPY)
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = self.system.AddObject(items.ObjectGround())
        self.bodies = {name: self._link(i, name) for i, name in enumerate(crane.LINKS)}
        self._joints()
        pins = self._pins()
        self.actuators = [self._actuator(i, *pins[name]) for i, name in enumerate(crane.CYLINDERS)]
        tip = items.SensorBody(
            bodyNumber=self.bodies["extension"],
            localPosition=[*self.numbers.point["extension.tip"], 0],
            storeInternal=True,
            writeToFile=False,
            outputVariableType=exu.OutputVariableType.Position,
        )
        self.tip = self.system.AddSensor(tip)
        self.system.Assemble()

    def _link(self, i: int, name: str) -> int:
        """A rigid body; its frame is the link's."""
        items, (cos, sin) = self.items, self.chain.turn[name]
        pose = [*map(float, self.chain.origin[name]), float(np.arctan2(sin, cos))]
        node = self.system.AddNode(items.NodeRigidBody2D(referenceCoordinates=pose))
        cog, mass = self.numbers.point[f"{name}.cog"], self.numbers.mass[i]
        about_frame = self.numbers.inertia[i] + mass * (cog[0] ** 2 + cog[1] ** 2)
        body = items.ObjectRigidBody2D(mass=mass, inertia=about_frame, centerOfMass=list(cog), nodeNumber=node)
        number = self.system.AddObject(body)
        weight = self.system.AddMarker(items.MarkerBodyMass(bodyNumber=number))
        gravity = [0, -self.numbers.gravity, 0]
        self.system.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=gravity))
        return number

    def marker(self, name: str, local: tuple[float, float] | None = None, rigid: bool = False) -> int:
        """A point of a link, or one of the pillar, which stands still at the origin."""
        link = name.split(".")[0]
        at = [*(self.numbers.point[name] if local is None else local), 0]
        kind = self.items.MarkerBodyRigid if rigid else self.items.MarkerBodyPosition
        return self.system.AddMarker(kind(bodyNumber=self.bodies.get(link, self.ground), localPosition=at))

    def _joints(self) -> None:
        origin = (0.0, 0.0)
        for parent, child in (("pillar.boom-joint", "boom"), ("boom.jib-joint", "jib")):
            ends = [self.marker(parent), self.marker(child, origin)]
            self.system.AddObject(self.items.ObjectJointRevolute2D(markerNumbers=ends))
        ends = [self.marker("jib.extension-origin", rigid=True), self.marker("extension", origin, rigid=True)]
        self.system.AddObject(self.items.ObjectJointPrismatic2D(markerNumbers=ends))

    def _pins(self) -> dict[str, tuple[int, int]]:
        """Both ends of each cylinder; the jib's rod ends at the mass that two rods hold."""
        items = self.items
        place = [float(x) for x in self.chain.four_bar()[0]]
        node = self.system.AddNode(items.NodePoint2D(referenceCoordinates=place))
        mass = self.system.AddObject(items.ObjectMassPoint2D(mass=PIN_MASS, nodeNumber=node))
        pin = self.system.AddMarker(items.MarkerBodyPosition(bodyNumber=mass))
        for pivot, length in zip(("boom.rocker-pivot", "jib.coupler-pivot"), self.numbers.four_bar, strict=True):
            ends = [self.marker(pivot), pin]
            self.system.AddObject(items.ObjectConnectorDistance(markerNumbers=ends, distance=length))
        return {
            "lift": (self.marker("boom.lift-barrel"), self.marker("pillar.lift-rod")),
            "jib": (self.marker("boom.jib-barrel"), pin),
            "extension": (self.marker("jib.extension-barrel"), self.marker("extension.rod")),
        }

    def _actuator(self, i: int, barrel: int, rod: int) -> int:
        c = {name: float(values[i]) for name, values in self.numbers.cylinder.items()}
        first = 2 * crane.JOINTS + crane.OWN_STATES * i
        start = {"referenceCoordinates": [0, 0], "numberOfODE1Coordinates": 2}
        start["initialCoordinates"] = list(self.problem.start[first : first + 2])
        node = self.system.AddNode(self.items.NodeGenericODE1(**start))
        viscous = (c["viscous-out"] + c["viscous-in"]) / 2 * np.sqrt(FRICTION_SPEED)
        stroke = float(self.problem.crane.spool_strokes[i])
        actuator = self.items.ObjectConnectorHydraulicActuatorSimple(
            markerNumbers=[barrel, rod],
            nodeNumbers=[node],
            offsetLength=c["mid-length"] - c["half"],
            strokeLength=2 * c["half"],
            chamberCrossSection0=c["area-1"],
            chamberCrossSection1=c["area-2"],
            hoseVolume0=c["dead"],
            hoseVolume1=c["dead"],
            actuatorDamping=float(viscous),
            oilBulkModulus=float(self.problem.crane.bulk_modulus(BULK_PRESSURE)),
            nominalFlow=c["conductance"] * stroke,
            systemPressure=self.numbers.supply,
            tankPressure=self.numbers.tank,
            useChamberVolumeChange=True,
        )
        return self.system.AddObject(actuator)

    def run(self, step: float) -> Solution:
        """The tip at the record times (rows, 2), by implicit steps of one length."""
        changes = list(zip(self.problem.times, self.problem.spools / self.problem.crane.spool_strokes, strict=True))
        ahead = list(changes)

        def open_valves(system: Any, t: float) -> bool:
            # Exudyn asks with the time at which the step ends.
            while ahead and t > ahead[0][0] + step / 2:
                for actuator, opening in zip(self.actuators, ahead.pop(0)[1], strict=True):
                    system.SetObjectParameter(actuator, "valveOpening0", float(opening))
                    system.SetObjectParameter(actuator, "valveOpening1", float(-opening))
            return True

        self.system.SetPreStepUserFunction(open_valves)
        settings = self.exu.SimulationSettings()
        settings.timeIntegration.endTime = self.problem.end
        settings.timeIntegration.numberOfSteps = round(self.problem.end / step)
        settings.timeIntegration.verboseMode = 0
        settings.timeIntegration.newton.useModifiedNewton = True
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = float(self.problem.record[1] - self.problem.record[0])

        def work() -> np.ndarray:
            self.system.SolveDynamic(settings)
            return np.array(self.system.GetSensorStoredData(self.tip))[:, 1:3]

        return clocked(work, lambda: {"steps": settings.timeIntegration.numberOfSteps})


def measure(problem: Problem, target: float, steps: tuple[float, ...] = STEPS) -> dict[str, Any]:
    """Tip errors and times per step, and the longest step within the target, if any."""
    model = Model(problem)
    # Its error goes with the step, as pressures do; two small steps carry it on to none.
    exact = 2 * model.run(REFERENCE_STEP).states - model.run(2 * REFERENCE_STEP).states
    points = []
    for step in steps:
        run = model.run(step)
        if run.states.shape == exact.shape:
            error = float(np.linalg.norm(run.states - exact, axis=1).max())
            points.append({"step": step, "tip_error_m": error, "seconds": run.seconds} | run.counts)
    within = [point for point in points if point["tip_error_m"] <= target]
    # How far its tip ends up from that of the full model: what the differences amount to.
    apart = float(np.linalg.norm(exact - problem.exact, axis=1).max())
    return {"points": points, "chosen": min(within, key=lambda p: p["seconds"], default=None), "apart_m": apart}
