/** Live charts, two at first, each of a group of signals that one picks; their cursors go together. */

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { button, make } from "./elements";
import type { History } from "./history";
import type { Description, Signal } from "./messages";
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
/** Groups of the charts at first, and of those that somebody adds. */
const FIRST = [7, 2];
const NEXT = [3, 9, 0, 4];
/** Share of its stroke from which a spool counts as nearly fully open: the controllers keep a little in hand. */
const OPEN = 0.85;

/** Time shown, s. */
const SPAN = 20;
/** Rows from one that is drawn to the next, at 100 a second: 500 points per chart. */
const STRIDE = 4;
/** Free above and below the lines, as a share of their range. */
const AIR = 0.08;

interface Chart {
  holder: HTMLElement;
  room: HTMLElement;
  /** Time at the cursor. */
  time: HTMLElement;
  select: HTMLSelectElement;
  plot: uPlot | null;
  signals: Signal[];
  scales: number[];
}

export class Charts {
  private charts: Chart[] = [];
  private readonly more = button("+ Chart", "Add a chart of other signals", () => this.grow(), "more");
  private readonly open = make("span", { className: "open", hidden: true }, make("i"), `a spool beyond ${100 * OPEN} % of its stroke`);
  /** Spool travel from which a valve is nearly fully open, by signal, m. */
  private travels: [string, number][] = [];
  /** Times from and until which one is, s. */
  private spans: [number, number][] = [];

  constructor(
    private readonly room: HTMLElement,
    private readonly history: History,
  ) {
    room.append(make("div", { id: "more-charts" }, this.more, this.open));
    for (const group of FIRST) this.add(group);
    new ResizeObserver(() => this.resize()).observe(room);
  }

  private add(group: number): Chart {
    const select = make("select");
    select.setAttribute("aria-label", "Signals of this chart");
    GROUPS.forEach(({ title, unit }, i) => select.add(new Option(`${title} [${unit}]`, String(i), i === group, i === group)));
    const plotRoom = make("div", { className: "plot" });
    const time = make("output", { className: "cursor-time" });
    const close = button("×", "Remove this chart", () => this.remove(chart));
    const holder = make("div", { className: "chart" }, make("div", { className: "chart-head" }, select, time, close), plotRoom);
    this.room.insertBefore(holder, this.room.lastElementChild);
    const chart: Chart = { holder, room: plotRoom, time, select, plot: null, signals: [], scales: [] };
    select.addEventListener("change", () => this.build(chart));
    this.charts.push(chart);
    return chart;
  }

  private grow(): void {
    const shown = this.charts.map(({ select }) => Number(select.value));
    this.build(this.add([...FIRST, ...NEXT].find((group) => !shown.includes(group)) ?? 0));
    this.change();
  }

  private remove(chart: Chart): void {
    chart.plot?.destroy();
    chart.holder.remove();
    this.charts = this.charts.filter((other) => other !== chart);
    this.change();
  }

  /** Another number of charts. */
  private change(): void {
    this.more.disabled = this.charts.length >= FIRST.length + NEXT.length;
    this.resize();
  }

  rebuild({ cylinders }: Description): void {
    this.travels = cylinders.map(({ name, spool }) => [`cylinder.${name}.xs`, OPEN * spool]);
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
        cursor: { drag: { x: true, y: false }, points: { size: 6 }, sync: { key: "time" } },
        hooks: {
          drawClear: [(plot) => this.shade(plot, colours.shade)],
          setCursor: [({ cursor, data }) => this.tellTime(chart, data[0]?.[cursor.idx ?? -1])],
        },
        legend: { live: true, markers: { width: 0 } },
        padding: [7, 16, 0, 0],
        scales: { x: { time: false }, y: { range: (_, low, high) => rangeOf(group, low, high) } },
        axes: [
          { ...axis, size: 22, space: 44, values: (_, ticks) => ticks.map((t) => `${Math.round(t * 100) / 100} s`) },
          { ...axis, size: 46, space: (_plot, _axis, _low, _high, height) => (height > 160 ? 34 : 16) },
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
    this.drawOne(chart);
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

  private tellTime(chart: Chart, time: number | null | undefined): void {
    chart.time.textContent = time == null ? "" : `${time.toFixed(2)} s`;
  }

  /** Times at which a valve can hardly open further: the crane cannot be faster then. */
  private shade({ ctx, bbox, valToPos }: uPlot, colour: string): void {
    ctx.fillStyle = colour;
    for (const [from, to] of this.spans) {
      const [left, right] = [from, to].map((time) => Math.min(Math.max(valToPos(time, "x", true), bbox.left), bbox.left + bbox.width));
      ctx.fillRect(left!, bbox.top, right! - left!, bbox.height);
    }
  }

  private findSpans(from: number, stride: number): void {
    const [times, ...spools] = this.history.columns(["time", ...this.travels.map(([name]) => name)], from, stride, [1, ...this.travels.map(() => 1)]);
    this.spans = [];
    times!.forEach((time, i) => {
      if (!spools.some((spool, c) => Math.abs(spool[i] ?? 0) >= this.travels[c]![1])) return;
      const [last, before] = [this.spans.at(-1), times![i - 1] ?? time!];
      if (last && last[1] === before) last[1] = time!;
      else this.spans.push([before!, time!]);
    });
    this.open.hidden = !this.spans.length;
  }

  /** `follow`: the newest at the right edge; else what is shown stays. */
  draw(follow: boolean): void {
    if (!follow) return;
    this.findSpans(this.history.last - SPAN, STRIDE);
    this.charts.forEach((chart) => this.drawOne(chart));
  }

  private drawOne(chart: Chart): void {
    if (!chart.plot) return;
    // Without values under the cursor the legend needs less room.
    if (!chart.time.textContent) this.resizeOne(chart);
    const names = ["time", ...chart.signals.map((signal) => signal.name)];
    const now = this.history.last;
    const numbers = this.history.columns(names, now - SPAN, STRIDE, [1, ...chart.scales]);
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
    const [size, plot] = [this.size(chart), chart.plot];
    if (plot && (plot.width !== size.width || plot.height !== size.height)) plot.setSize(size);
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
  if (parts[0] === "wanted") return `requested ${parts[1]!.slice(1)}`;
  if (parts[0] === "tip") return `tip ${parts[1]!.slice(1)}`;
  return name.replaceAll(".", " ");
}
