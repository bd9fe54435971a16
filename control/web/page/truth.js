// The truth of a picture, drawn over it: boxes, names, visible fraction, body points (docs/truth.md).

const bones = [[5, 7], [7, 9], [6, 8], [8, 10], [5, 6], [5, 11], [6, 12], [11, 12], [11, 13], [13, 15], [12, 14], [14, 16], [0, 5], [0, 6]];

/** The same colour for the same object in every camera. */
export function colourOf(id) { return `hsl(${(id * 137) % 360} 75% 66%)`; }

function label(context, text, x, y, unit, colour) {
  context.font = `${12 * unit}px system-ui, sans-serif`;
  const width = context.measureText(text).width + 8 * unit;
  const top = Math.max(0, y - 17 * unit);
  context.fillStyle = '#0d1117d0';
  context.fillRect(x, top, width, 17 * unit);
  context.fillStyle = colour;
  context.fillText(text, x + 4 * unit, top + 12.5 * unit);
}

function drawPoints(context, points, unit, colour) {
  context.lineWidth = 1.5 * unit;
  context.strokeStyle = colour;
  for (const [a, b] of bones) {
    if (!points[a]?.[2] || !points[b]?.[2]) continue;
    context.globalAlpha = points[a][2] === 2 && points[b][2] === 2 ? 0.9 : 0.35;
    context.beginPath();
    context.moveTo(points[a][0], points[a][1]);
    context.lineTo(points[b][0], points[b][1]);
    context.stroke();
  }
  context.globalAlpha = 1;
  for (const [x, y, v] of points) {
    if (!v) continue;
    context.beginPath();
    context.arc(x, y, 2.2 * unit, 0, 2 * Math.PI);
    if (v === 2) { context.fillStyle = colour; context.fill(); } else { context.lineWidth = unit; context.stroke(); }
  }
}

/** Objects that move or are named first; those of scenery as large as the picture tell nothing and are left out. */
function worthDrawing(one, size) {
  return one.box && !(one.box[2] * one.box[3] > 0.9 * size[0] * size[1]);
}

/** Draws `truth` on a canvas that lies over the picture; unit: canvas pixels per CSS pixel. Gives how many boxes. */
export function drawTruth(canvas, truth, cssWidth) {
  if (canvas.width !== truth.size[0] || canvas.height !== truth.size[1]) [canvas.width, canvas.height] = truth.size;
  const context = canvas.getContext('2d');
  context.clearRect(0, 0, canvas.width, canvas.height);
  const unit = Math.max(0.5, canvas.width / Math.max(1, cssWidth));
  const shown = truth.objects.filter((one) => worthDrawing(one, truth.size));
  for (const one of shown) {
    const colour = colourOf(one.id);
    context.strokeStyle = colour;
    if (one.visible_fraction < 0.995 && one.box_full) {
      context.setLineDash([4 * unit, 4 * unit]);
      context.lineWidth = unit;
      context.strokeRect(...one.box_full);
      context.setLineDash([]);
    }
    context.lineWidth = 2 * unit;
    context.strokeRect(...one.box);
    if (one.keypoints) drawPoints(context, one.keypoints, unit, colour);
  }
  for (const one of shown)
    label(context, `${one.name} ${Math.round(100 * one.visible_fraction)} %`, one.box[0], one.box[1], unit, colourOf(one.id));
  canvas.dataset.boxes = JSON.stringify(shown.map((one) => [one.name, ...one.box]));
  canvas.dataset.sequence = String(truth.sequence);
  canvas.setAttribute('aria-label', 'Truth overlay: ' + (shown.map((one) => `${one.name}, ${Math.round(100 * one.visible_fraction)} percent visible`).join('; ') || 'nothing in view'));
}

export function clearTruth(canvas) {
  canvas.getContext('2d').clearRect(0, 0, canvas.width, canvas.height);
  delete canvas.dataset.boxes;
  canvas.setAttribute('aria-label', 'Truth overlay, off');
}
