// Shapes that are drawn in the photo, and what they are in metres. Nothing here asks or shows anything.

export const kinds = {
  walkable: { label: 'Walkable', least: 3, hint: 'corners of a piece of ground where people may go' },
  obstacle: { label: 'Obstacle', least: 3, height_m: 1, hint: 'corners of its foot on the ground; a box of its height stands there' },
  wall: { label: 'Wall', least: 2, height_m: 3, hint: 'its line on the ground, from corner to corner' },
  cutout: { label: 'Cut-out', least: 4, hint: 'its outline, and last where it stands on the ground: trees, poles, fences' },
};
/** What a shape does, as `role` of the scene file has it; what is walkable is no shape. */
export const roles = { both: 'hides, catches shadows', catcher: 'catches shadows only', holdout: 'hides only' };
export const hasRole = ({ kind }) => kind !== 'walkable';
/** The role as a shape of the file has it: nothing where it is the usual one. */
export const roleOf = ({ role = 'both' }) => (role === 'both' ? {} : { role });

const wallThickness = 0.1;

const degrees = (radians) => (radians * 180) / Math.PI;

/** The least rectangle with a side along one of the polygon's. */
function rectangleAbout(corners) {
  let best = null;
  for (let i = 0; i < corners.length; i += 1) {
    const [from, to] = [corners[i], corners[(i + 1) % corners.length]];
    const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const along = corners.map(([x, y]) => c * x + s * y);
    const across = corners.map(([x, y]) => c * y - s * x);
    const [a, b, low, high] = [Math.min(...along), Math.max(...along), Math.min(...across), Math.max(...across)];
    const size = [b - a, high - low];
    if (best && size[0] * size[1] >= best.size[0] * best.size[1]) continue;
    const [u, v] = [(a + b) / 2, (low + high) / 2];
    best = { middle: [c * u - s * v, s * u + c * v], size, yaw_deg: degrees(angle) };
  }
  return best;
}

/** Boxes of a shape whose corners are at `ground` (metres): as `boxes` of a backdrop's proxies. `camera`: its position. */
export function boxesOf(shape, ground, camera) {
  if (shape.kind === 'obstacle') {
    const { middle, size, yaw_deg } = rectangleAbout(ground);
    return [{ position: [...middle, 0], size: [...size.map((side) => Math.max(side, 0.01)), shape.height_m], yaw_deg, ...roleOf(shape) }];
  }
  if (shape.kind !== 'wall') return [];
  return ground.slice(1).map((to, index) => {
    const from = ground[index];
    const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    const length = Math.max(Math.hypot(dx, dy), 0.01);
    const middle = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
    // Its line is the foot that the photo shows: it is thick away from the camera.
    const side = Math.sign(dx * (middle[1] - camera[1]) - dy * (middle[0] - camera[0])) || 1;
    const away = (side * wallThickness) / 2 / length;
    return { position: [middle[0] - dy * away, middle[1] + dx * away, 0], size: [length, wallThickness, shape.height_m], yaw_deg: degrees(Math.atan2(dy, dx)), ...roleOf(shape) };
  });
}

/** The foot of a box. */
export function footOf({ position, size, yaw_deg }) {
  const [c, s] = [Math.cos((yaw_deg * Math.PI) / 180), Math.sin((yaw_deg * Math.PI) / 180)];
  return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => {
    const [u, v] = [(x * size[0]) / 2, (y * size[1]) / 2];
    return [position[0] + c * u - s * v, position[1] + s * u + c * v];
  });
}

export function isInside(polygon, [x, y]) {
  let inside = false;
  polygon.forEach(([ax, ay], index) => {
    const [bx, by] = polygon.at(index - 1);
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) inside = !inside;
  });
  return inside;
}

/** At most `count` places inside of a polygon and of none of the obstacles, spread over it. */
export function placesIn(polygon, obstacles, count) {
  const [xs, ys] = [polygon.map(([x]) => x), polygon.map(([, y]) => y)];
  const [left, low, width, depth] = [Math.min(...xs), Math.min(...ys), Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys)];
  const places = [];
  // Halton's sequence of bases 2 and 3 fills a rectangle evenly, however many are taken of it.
  const halton = (index, base) => { let [sum, share] = [0, 1]; for (let i = index; i > 0; i = Math.floor(i / base)) { share /= base; sum += share * (i % base); } return sum; };
  for (let index = 1; places.length < count && index < 4000; index += 1) {
    const place = [left + width * halton(index, 2), low + depth * halton(index, 3)];
    if (isInside(polygon, place) && !obstacles.some((one) => isInside(one, place))) places.push(place);
  }
  return places;
}
