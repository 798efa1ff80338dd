/** Live charts: four at a time, each of a group of signals that one picks. */

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import type { History } from "./history";
import type { Signal } from "./messages";
import { palette } from "./palette";

interface Group {
  title: string;
  unit: string;
  scale: number;
  /** Shown at least, in the unit: noise at rest is not blown up to a mountain. */
  least: [number, number] | null;
  has: (name: string) => boolean;
}

const ends =
  (...tails: string[]) =>
  (name: string): boolean =>
    tails.some((tail) => name.endsWith(tail)) && !name.startsWith("ledger");
const ofCylinder = (what: string) => (name: string) => name.startsWith("cylinder.") && name.endsWith(`.${what}`);
const ledger =
  (...terms: string[]) =>
  (name: string): boolean =>
    terms.some((term) => name === `ledger.${term}`);

const ENERGIES = ledger("supply", "friction", "internal_leakage", "connector", "end_stop");
const EDGES = ledger("edge_pa", "edge_at", "edge_pb", "edge_bt");

const shows = (title: string, unit: string, scale: number, least: Group["least"], has: Group["has"]): Group => ({
  title,
  unit,
  scale,
  least,
  has,
});

const GROUPS: Group[] = [
  shows("Joint angles and telescope", "° · dm", 1, null, (n) => /^joint\..*\.q$/.test(n)),
  shows("Joint speeds", "°/s · dm/s", 1, [-2, 2], (n) => /^joint\..*\.qd$/.test(n)),
  shows("Chamber pressures", "bar", 1e-5, [0, 100], ends(".p1", ".p2")),
  shows("Spool positions", "mm", 1e3, [-10, 10], ends(".xs")),
  shows("Cylinder forces", "kN", 1e-3, [0, 1], ofCylinder("force")),
  shows("Friction", "N", 1, [-100, 100], ofCylinder("friction")),
  shows("Piston speeds", "mm/s", 1e3, [-10, 10], ofCylinder("v")),
  shows("Velocity of the tip", "m/s", 1, [-0.1, 0.1], (n) => /^(tip|wanted)\.v[xz]$/.test(n)),
  shows("Supply flow", "l/min", 6e4, [0, 10], (n) => n === "supply.flow"),
  shows("Supply power", "kW", 1e-3, [0, 2], (n) => n === "supply.power"),
  shows("Energy since the start", "kJ", 1e-3, [0, 2], ENERGIES),
  shows("Losses at metering edges", "kJ", 1e-3, [0, 1], EDGES),
];
const FIRST = [7, 2, 3, 9];

/** Time shown, s. */
const SPAN = 20;
/** Rows drawn at most per chart. */
const POINTS = 500;
/** Free above and below the lines, as a share of their range. */
const AIR = 0.08;

interface Chart {
  room: HTMLElement;
  select: HTMLSelectElement;
  plot: uPlot | null;
  signals: Signal[];
  scales: number[];
}

export class Charts {
  private readonly charts: Chart[] = [];

  constructor(
    room: HTMLElement,
    private readonly history: History,
  ) {
    for (const group of FIRST) this.charts.push(this.add(room, group));
    new ResizeObserver(() => this.resize()).observe(room);
  }

  private add(room: HTMLElement, group: number): Chart {
    const holder = document.createElement("div");
    holder.className = "chart";
    const select = document.createElement("select");
    select.setAttribute("aria-label", "Signals of this chart");
    GROUPS.forEach(({ title, unit }, i) => select.add(new Option(`${title} [${unit}]`, String(i), i === group, i === group)));
    const plotRoom = document.createElement("div");
    plotRoom.className = "plot";
    holder.append(select, plotRoom);
    room.append(holder);
    const chart: Chart = { room: plotRoom, select, plot: null, signals: [], scales: [] };
    select.addEventListener("change", () => this.build(chart));
    return chart;
  }

  rebuild(): void {
    this.charts.forEach((chart) => this.build(chart));
  }

  private build(chart: Chart): void {
    chart.plot?.destroy();
    const group = GROUPS[Number(chart.select.value)]!;
    chart.signals = this.history.signals.filter(({ name }) => group.has(name));
    chart.scales = chart.signals.map(({ unit }) => group.scale * displayScale(unit, group.unit));
    const colours = palette();
    const axis = { stroke: colours.faint, grid: { stroke: colours.grid, width: 1 }, ticks: { show: false }, font: "11px system-ui" };
    chart.plot = new uPlot(
      {
        ...this.size(chart),
        cursor: { drag: { x: true, y: false }, points: { size: 6 } },
        legend: { live: true, markers: { width: 0 } },
        padding: [7, 16, 0, 0],
        scales: { x: { time: false }, y: { range: (_, low, high) => rangeOf(group, low, high) } },
        axes: [
          { ...axis, size: 22, space: 44, values: (_, ticks) => ticks.map((t) => `${Math.round(t * 100) / 100} s`) },
          { ...axis, size: 46, space: 16 },
        ],
        series: [
          { label: "t", value: (_, t) => (t == null ? "" : `${t.toFixed(2)} s`) },
          ...chart.signals.map((signal) => {
            const { colour, dash } = this.line(chart.signals, signal);
            return {
              label: shortName(signal.name),
              stroke: colours.lines[colour % colours.lines.length]!,
              width: 1.7,
              dash,
              value: (_: uPlot, value: number | null) => (value == null ? "" : value.toPrecision(4)),
            };
          }),
        ],
      },
      [[], ...chart.signals.map(() => [])],
      chart.room,
    );
    this.markLegend(chart);
    this.resizeOne(chart);
    this.drawOne(chart, true);
  }

  /** Signals of one part share a colour; the second of them is dashed, so that no eye depends on colours alone. */
  private line(signals: Signal[], signal: Signal): { colour: number; dash: number[] } {
    const parts = [...new Set(signals.map(({ name }) => partOf(name)))];
    const second = signals.find(({ name }) => partOf(name) === partOf(signal.name)) !== signal;
    return { colour: parts.indexOf(partOf(signal.name)), dash: second ? [5, 4] : [] };
  }

  /** Pieces of the lines themselves as marks. */
  private markLegend(chart: Chart): void {
    const marks = chart.room.querySelectorAll<HTMLElement>(".u-series:not(:first-child) .u-marker");
    chart.signals.forEach((signal, i) => {
      const { colour, dash } = this.line(chart.signals, signal);
      const lines = palette().lines;
      marks[i]!.style.borderTop = `3px ${dash.length ? "dashed" : "solid"} ${lines[colour % lines.length]!}`;
    });
  }

  /** `follow`: the newest at the right edge; else what is shown stays. */
  draw(follow: boolean): void {
    this.charts.forEach((chart) => this.drawOne(chart, follow));
  }

  private drawOne(chart: Chart, follow: boolean): void {
    if (!chart.plot || !follow) return;
    const names = ["time", ...chart.signals.map((signal) => signal.name)];
    const [last] = this.history.columns(["time"], -Infinity, Math.max(this.history.length - 1, 1), [1]);
    const now = last?.at(-1) ?? 0;
    const stride = Math.max(Math.ceil((SPAN * 100) / POINTS), 1);
    const numbers = this.history.columns(names, now - SPAN, stride, [1, ...chart.scales]);
    // What there is none of, as the velocity asked for by levers, must not take the others with it.
    const columns = numbers.map((column) => column.map((value) => (Number.isNaN(value) ? null : value)));
    chart.plot.setData(columns as unknown as uPlot.AlignedData, false);
    chart.plot.batch(() => {
      chart.plot?.setScale("x", { min: Math.max(now - SPAN, 0), max: Math.max(now, SPAN) });
    });
  }

  private size(chart: Chart): { width: number; height: number } {
    const legend = chart.room.querySelector<HTMLElement>(".u-legend")?.offsetHeight ?? 20;
    return { width: Math.max(chart.room.clientWidth, 120), height: Math.max(chart.room.clientHeight - legend, 60) };
  }

  private resizeOne(chart: Chart): void {
    chart.plot?.setSize(this.size(chart));
  }

  private resize(): void {
    this.charts.forEach((chart) => this.resizeOne(chart));
  }
}

/** Range of an axis around lines from `low` to `high`, null where there are none. */
function rangeOf({ least }: Group, low: number | null, high: number | null): [number, number] {
  const bottom = Math.min(low ?? 0, least?.[0] ?? Infinity);
  const top = Math.max(high ?? 1, least?.[1] ?? bottom + 1);
  const air = AIR * (top - bottom);
  return [bottom === 0 ? 0 : bottom - air, top + air];
}

/** What signals of one colour have in common: the cylinder, or the direction of a velocity. */
function partOf(name: string): string {
  const parts = name.split(".");
  return parts[0] === "cylinder" ? parts[1]! : /^(tip|wanted)\./.test(name) ? parts[1]! : name;
}

/** Joints turn in degrees and slide in decimetres, so that one chart serves both. */
function displayScale(unit: string, shown: string): number {
  if (!shown.includes("°")) return 1;
  return unit.startsWith("rad") ? 180 / Math.PI : 10;
}

function shortName(name: string): string {
  const parts = name.split(".");
  if (parts[0] === "ledger") return parts[1]!.replaceAll("_", " ");
  if (parts[0] === "joint") return parts[1]!;
  if (parts[0] === "cylinder") return /^p[12]$/.test(parts[2]!) ? `${parts[1]} ${parts[2]}` : parts[1]!;
  if (parts[0] === "wanted") return `asked ${parts[1]!.slice(1)}`;
  if (parts[0] === "tip") return `tip ${parts[1]!.slice(1)}`;
  return name.replaceAll(".", " ");
}
