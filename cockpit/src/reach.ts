/** The area that the tip can reach, of the curves around it: one path that is filled as a whole. */

import type { Point } from "./messages";

const closed = (curve: Point[]): boolean => {
  const [first, last] = [curve[0]!, curve.at(-1)!];
  return Math.hypot(first[0] - last[0], first[1] - last[1]) < 1e-9;
};

const area = (ring: Point[]): number =>
  ring.reduce((sum, [x, z], i) => {
    const [x1, z1] = ring[(i + 1) % ring.length]!;
    return sum + x * z1 - z * x1;
  }, 0);

/** Rings go round one way, so that parts that overlap never cancel. */
function add(path: Path2D, ring: Point[]): void {
  const points = area(ring) < 0 ? [...ring].reverse() : ring;
  points.forEach(([x, z], i) => (i ? path.lineTo(x, z) : path.moveTo(x, z)));
  path.closePath();
}

export interface Reach {
  area: Path2D;
  /** Curves that surround nothing: the way of a single joint, the arc of full reach. */
  lines: Path2D;
}

/** Rings of as many points are the same joints at other places of a telescope, which sweeps what is between them. */
export function reachOf(curves: Point[][]): Reach {
  const reach = { area: new Path2D(), lines: new Path2D() };
  const rings = curves.filter((curve) => curve.length > 3 && closed(curve));
  rings.forEach((ring, r) => {
    add(reach.area, ring);
    const other = rings.slice(r + 1).find(({ length }) => length === ring.length);
    if (!other) return;
    for (let i = 0; i + 1 < ring.length; i++) add(reach.area, [ring[i]!, ring[i + 1]!, other[i + 1]!, other[i]!]);
  });
  for (const curve of curves.filter((curve) => !rings.includes(curve))) {
    curve.forEach(([x, z], i) => (i ? reach.lines.lineTo(x, z) : reach.lines.moveTo(x, z)));
  }
  return reach;
}
