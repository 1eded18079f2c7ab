"use strict";
// What the pages of runs share.
const byId = (id) => document.getElementById(id);
const make = (tag, parent, text) => {
  const element = document.createElement(tag);
  if (text !== undefined) element.textContent = text;
  parent.append(element);
  return element;
};
// The digits that count, without the tail of binary fractions.
const figure = (value, digits = 4) =>
  value === null || value === undefined ? "-"
    : typeof value !== "number" ? String(value)
    : Number.isInteger(value) ? String(value)
    : Math.abs(value) >= 1e6 || Math.abs(value) < 1e-4 ? value.toExponential(digits - 1)
    : String(Number(value.toPrecision(digits)));

// Colours of the page, which the canvases share.
let colours = {};
const readColours = () => {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["paper", "ink", "faint", "line", "estimate", "truth", "reckoned", "static", "moving", "missed", "hit", "stray",
    "particle", "landmark"]) colours[name] = style.getPropertyValue("--" + name).trim();
};
const setTheme = (theme) => {
  document.documentElement.dataset.theme = theme;
  readColours();
};
setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");

// A canvas with as many dots as the screen has.
const context = (canvas) => {
  const scale = window.devicePixelRatio || 1;
  const { width, height } = canvas.getBoundingClientRect();
  const [w, h] = [Math.max(1, Math.round(width * scale)), Math.max(1, Math.round(height * scale))];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const c = canvas.getContext("2d");
  c.setTransform(scale, 0, 0, scale, 0, 0);
  c.clearRect(0, 0, width, height);
  c.font = "12px system-ui, sans-serif";
  return [c, width, height];
};
// Round numbers between two, about so many.
const ticks = (low, high, about) => {
  const raw = (high - low) / Math.max(1, about);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= raw);
  const list = [];
  for (let at = Math.ceil(low / step) * step; at <= high + 1e-9 * step; at += step) list.push(at);
  return [list, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))];
};

// A net of round numbers under a map that is seen so; the names of its coordinates.
const drawGrid = (c, width, height, view, [right, up]) => {
  c.strokeStyle = colours.line;
  c.fillStyle = colours.faint;
  c.lineWidth = 1;
  const half = [width / view.scale / 2, height / view.scale / 2];
  const [xs, xDigits] = ticks(view.x - half[0], view.x + half[0], width / 110);
  const [ys, yDigits] = ticks(view.y - half[1], view.y + half[1], height / 90);
  c.beginPath();
  for (const at of xs) { const x = width / 2 + (at - view.x) * view.scale; c.moveTo(x, 0); c.lineTo(x, height); }
  for (const at of ys) { const y = height / 2 - (at - view.y) * view.scale; c.moveTo(0, y); c.lineTo(width, y); }
  c.stroke();
  for (const at of xs) c.fillText(at.toFixed(xDigits), width / 2 + (at - view.x) * view.scale + 3, height - 5);
  for (const at of ys) c.fillText(at.toFixed(yDigits), 4, height / 2 - (at - view.y) * view.scale - 3);
  c.textAlign = "right";
  c.fillText(right + " (m) to the right, " + up + " (m) upwards", width - 8, 15);
  c.textAlign = "left";
};

// What part of points is seen: all of them, with a margin.
const viewOf = (canvas, [[x0, x1], [y0, y1]]) => {
  const rect = canvas.getBoundingClientRect();
  return { x: (x0 + x1) / 2, y: (y0 + y1) / 2, scale: Math.min(rect.width / (x1 - x0), rect.height / (y1 - y0)) };
};

// Fingers, mouse and wheel move a map; returns what zooms it.
const movable = (canvas, viewNow, draw, dragged) => {
  const fingers = new Map();
  const zoom = (factor, x, y) => {
    const view = viewNow();
    const rect = canvas.getBoundingClientRect();
    const [dx, dy] = [(x - rect.width / 2) / view.scale, (rect.height / 2 - y) / view.scale];
    view.x += dx - dx / factor;
    view.y += dy - dy / factor;
    view.scale *= factor;
    draw();
  };
  canvas.addEventListener("pointerdown", (e) => { canvas.setPointerCapture(e.pointerId); fingers.set(e.pointerId, [e.offsetX, e.offsetY]); });
  canvas.addEventListener("pointermove", (e) => {
    const before = fingers.get(e.pointerId);
    if (!before) return;
    const now = [e.offsetX, e.offsetY];
    if (fingers.size === 1) {
      const view = viewNow();
      dragged();
      view.x -= (now[0] - before[0]) / view.scale;
      view.y += (now[1] - before[1]) / view.scale;
      draw();
    } else if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== e.pointerId)[1];
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      if (apart(before) > 0) zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    }
    fingers.set(e.pointerId, now);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (e) => fingers.delete(e.pointerId));
  canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(-e.deltaY / 400), e.offsetX, e.offsetY); }, { passive: false });
  return zoom;
};

// Curves over time, from zero upwards; each line is its times, its values, of which some may be null, and a colour. Returns where a time lies.
const CHART = { left: 56, right: 8, bottom: 20 };
const drawChart = (c, width, height, [t0, t1], lines) => {
  const { left, right, bottom } = CHART;
  let high = 0;
  for (const [, values] of lines) for (const v of values) if (v !== null && v > high) high = v;
  high = high > 0 ? 1.05 * high : 1;
  const X = (t) => left + (t - t0) / (t1 - t0) * (width - left - right);
  const Y = (v) => height - bottom - v / high * (height - bottom - 8);
  const [rows, digits] = ticks(0, high, height / 45);
  const [columns, columnDigits] = ticks(t0, t1, width / 110);
  c.strokeStyle = colours.line;
  c.fillStyle = colours.faint;
  c.lineWidth = 1;
  c.beginPath();
  for (const v of rows) { c.moveTo(left, Y(v)); c.lineTo(width, Y(v)); }
  for (const t of columns) { c.moveTo(X(t), 4); c.lineTo(X(t), height - bottom); }
  c.stroke();
  c.textAlign = "right";
  for (const v of rows) c.fillText(v.toFixed(digits), left - 5, Y(v) + 4);
  c.textAlign = "center";
  for (const t of columns) c.fillText(t.toFixed(columnDigits) + " s", Math.min(X(t), width - 20), height - 5);
  c.textAlign = "left";
  for (const [times, values, colour] of lines) {
    c.strokeStyle = colour;
    c.lineWidth = 1.3;
    c.beginPath();
    let pen = false;
    values.forEach((v, k) => {
      if (v === null) { pen = false; return; }
      if (pen) c.lineTo(X(times[k]), Y(v)); else c.moveTo(X(times[k]), Y(v));
      pen = true;
    });
    c.stroke();
    // What is known at single scans alone.
    c.fillStyle = colour;
    values.forEach((v, k) => {
      const alone = v !== null && (values[k - 1] ?? null) === null && (values[k + 1] ?? null) === null;
      if (alone) c.fillRect(X(times[k]) - 2, Y(v) - 2, 4, 4);
    });
  }
  return X;
};
const timeAt = (canvas, [t0, t1], x) => t0 + (x - CHART.left) / (canvas.getBoundingClientRect().width - CHART.left - CHART.right) * (t1 - t0);
