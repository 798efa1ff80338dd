/** Keeps what a machine file states within what a picture can show: no loop and no drawing grows with a number in a file. */

import type { Description, Point } from "./messages";

/** Farthest place that is drawn, m, and corners of an outline that are. */
const FARTHEST = 1e4;
const CORNERS = 1000;

const near = (value: number): number => Math.min(Math.max(value, -FARTHEST), FARTHEST) || 0;

function outline(corners: Point[]): Point[] {
  const stride = Math.max(1, Math.ceil(corners.length / CORNERS));
  return corners.filter((_, i) => i % stride === 0).map(([x, z]): Point => [near(x), near(z)]);
}

/** The description with outlines that can be drawn. */
export function drawable(description: Description): Description {
  const regions = description["keep-out"].slice(0, CORNERS).map(({ name, corners }) => ({ name, corners: outline(corners) }));
  const workspace = description.workspace.map((curve) => curve.map(([x, z]): Point => [near(x), near(z)]));
  const ground = description.ground && {
    height: near(description.ground.height),
    supports: description.ground.supports.map((support) => ({
      ...support,
      height: near(support.height),
      from: near(support.from),
      to: near(support.to),
      edge: near(support.edge),
    })),
  };
  return { ...description, "keep-out": regions, ground, workspace };
}

/** Least and largest of each coordinate; null where there is no point. */
export function extent(points: Point[]): [Point, Point] | null {
  if (!points.length) return null;
  const over = (pick: (a: number, b: number) => number, axis: 0 | 1): number =>
    points.reduce((so, point) => pick(so, point[axis]), points[0]![axis]);
  return [
    [over(Math.min, 0), over(Math.min, 1)],
    [over(Math.max, 0), over(Math.max, 1)],
  ];
}

/** Multiples of `step` from `low` to `high`, at most so many. */
export function multiples(step: number, low: number, high: number, most: number): number[] {
  const first = Math.ceil(low / step);
  const count = Math.min(Math.max(Math.floor(high / step) - first + 1, 0), most);
  return Array.from({ length: count || 0 }, (_, i) => (first + i) * step);
}
