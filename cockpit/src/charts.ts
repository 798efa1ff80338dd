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
  has: (name: string) => boolean;
}

const ends =
  (...tails: string[]) =>
  (name: string): boolean =>
    tails.some((tail) => name.endsWith(tail)) && !name.startsWith("ledger");

const ENERGIES = ["supply", "friction", "internal_leakage", "connector", "end_stop"];
const EDGES = ["edge_pa", "edge_at", "edge_pb", "edge_bt"];

const GROUPS: Group[] = [
  { title: "Joint angles and telescope", unit: "° · dm", scale: 1, has: (n) => /^joint\..*\.q$/.test(n) },
  { title: "Joint speeds", unit: "°/s · dm/s", scale: 1, has: (n) => /^joint\..*\.qd$/.test(n) },
  { title: "Chamber pressures", unit: "bar", scale: 1e-5, has: ends(".p1", ".p2") },
  { title: "Spool positions", unit: "mm", scale: 1e3, has: ends(".xs") },
  { title: "Cylinder forces", unit: "kN", scale: 1e-3, has: (n) => /^cylinder\..*\.force$/.test(n) },
  { title: "Friction", unit: "N", scale: 1, has: (n) => /^cylinder\..*\.friction$/.test(n) },
  { title: "Piston speeds", unit: "mm/s", scale: 1e3, has: (n) => /^cylinder\..*\.v$/.test(n) },
  { title: "Velocity of the tip", unit: "m/s", scale: 1, has: (n) => /^(tip|wanted)\.v[xz]$/.test(n) },
  { title: "Supply flow", unit: "l/min", scale: 6e4, has: (n) => n === "supply.flow" },
  { title: "Supply power", unit: "kW", scale: 1e-3, has: (n) => n === "supply.power" },
  { title: "Energy since the start", unit: "kJ", scale: 1e-3, has: (n) => ENERGIES.some((e) => n === `ledger.${e}`) },
  { title: "Losses at metering edges", unit: "kJ", scale: 1e-3, has: (n) => EDGES.some((e) => n === `ledger.${e}`) },
];
const FIRST = [7, 2, 3, 9];

/** Time shown, s. */
const SPAN = 20;
/** Rows drawn at most per chart. */
const POINTS = 500;

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
        legend: { live: true },
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 24, values: (_, ticks) => ticks.map((t) => `${Math.round(t * 100) / 100} s`) },
          { ...axis, size: 46, space: 18 },
        ],
        series: [
          { label: "t", value: (_, t) => (t == null ? "" : `${t.toFixed(2)} s`) },
          ...chart.signals.map((signal, i) => ({
            label: shortName(signal.name),
            stroke: colours.lines[i % colours.lines.length]!,
            width: 1.6,
            dash: i >= colours.lines.length ? [6, 4] : [],
            value: (_: uPlot, value: number | null) => (value == null ? "" : value.toPrecision(4)),
          })),
        ],
      },
      [[], ...chart.signals.map(() => [])],
      chart.room,
    );
    this.drawOne(chart, true);
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
    const columns = this.history.columns(names, now - SPAN, stride, [1, ...chart.scales]);
    chart.plot.setData(columns as unknown as uPlot.AlignedData, false);
    chart.plot.batch(() => {
      chart.plot?.setScale("x", { min: Math.max(now - SPAN, 0), max: Math.max(now, SPAN) });
    });
  }

  private size(chart: Chart): { width: number; height: number } {
    const legend = 38;
    return { width: Math.max(chart.room.clientWidth, 120), height: Math.max(chart.room.clientHeight - legend, 80) };
  }

  private resize(): void {
    this.charts.forEach((chart) => chart.plot?.setSize(this.size(chart)));
  }
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
