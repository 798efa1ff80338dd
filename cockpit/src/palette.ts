/** Colours with a meaning, told apart by colour-blind eyes too (Okabe and Ito); light and dark grounds differ. */

export interface Palette {
  ground: string;
  grid: string;
  ink: string;
  faint: string;
  steel: string;
  steelEdge: string;
  reach: string;
  reachEdge: string;
  forbidden: string;
  forbiddenEdge: string;
  soil: string;
  soilEdge: string;
  vehicle: string;
  vehicleFill: string;
  rod: string;
  load: string;
  actual: string;
  wanted: string;
  limit: string;
  trail: string;
  task: string;
  /** Times in charts at which a valve can hardly open further. */
  shade: string;
  /** An earlier drive. */
  ghost: string;
  /** Lines of charts, in order. */
  lines: string[];
}

const LIGHT: Palette = {
  ground: "#f7f8fa",
  grid: "#e3e7ec",
  ink: "#1d2733",
  faint: "#5a6672",
  steel: "#c3ccd6",
  steelEdge: "#56636f",
  reach: "rgba(0, 158, 115, 0.07)",
  reachEdge: "rgba(0, 158, 115, 0.38)",
  forbidden: "rgba(120, 130, 142, 0.16)",
  forbiddenEdge: "rgba(90, 100, 112, 0.55)",
  soil: "#e9e4da",
  soilEdge: "#a1937c",
  vehicle: "#b3bcc5",
  vehicleFill: "rgba(140, 152, 165, 0.1)",
  rod: "#8b97a3",
  load: "#9c6b3f",
  actual: "#0072b2",
  wanted: "#e69f00",
  limit: "#d55e00",
  trail: "#0072b2",
  task: "#cc79a7",
  shade: "rgba(213, 94, 0, 0.13)",
  ghost: "#7d5ba6",
  lines: ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5b5b5b"],
};

const DARK: Palette = {
  ground: "#12181f",
  grid: "#1f2933",
  ink: "#e7edf3",
  faint: "#97a4b0",
  steel: "#4a5866",
  steelEdge: "#a9b6c2",
  reach: "rgba(0, 190, 140, 0.08)",
  reachEdge: "rgba(0, 190, 140, 0.38)",
  forbidden: "rgba(150, 162, 175, 0.13)",
  forbiddenEdge: "rgba(160, 172, 185, 0.5)",
  soil: "#1f1c17",
  soilEdge: "#6f6553",
  vehicle: "#39454f",
  vehicleFill: "rgba(150, 162, 175, 0.06)",
  rod: "#c7d0d8",
  load: "#c08a58",
  actual: "#56b4e9",
  wanted: "#f0b429",
  limit: "#ff7a33",
  trail: "#56b4e9",
  task: "#dd93ba",
  shade: "rgba(255, 122, 51, 0.2)",
  ghost: "#b79be0",
  lines: ["#56b4e9", "#ff7a33", "#1fc79a", "#dd93ba", "#f0b429", "#7d9cff", "#b8b8b8"],
};

export const dark = (): boolean => {
  const chosen = document.documentElement.dataset["theme"];
  return chosen ? chosen === "dark" : window.matchMedia("(prefers-color-scheme: dark)").matches;
};

export const palette = (): Palette => (dark() ? DARK : LIGHT);

/** Stops of a scale that grows in lightness for every eye (viridis): low to high. */
const SCALE: [number, number, number][] = [
  [68, 1, 84],
  [65, 68, 135],
  [42, 120, 142],
  [34, 168, 132],
  [122, 209, 81],
  [253, 231, 37],
];

/** Colour of a share from 0 to 1, for example a pressure of the supply's. */
export function scaleColour(share: number): string {
  const place = Math.min(Math.max(share, 0), 1) * (SCALE.length - 1);
  const low = Math.min(Math.floor(place), SCALE.length - 2);
  const [a, b] = [SCALE[low]!, SCALE[low + 1]!];
  const mixed = a.map((value, i) => Math.round(value + (b[i]! - value) * (place - low)));
  return `rgb(${mixed.join(",")})`;
}
