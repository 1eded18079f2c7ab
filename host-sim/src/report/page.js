"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { summary, series, frames, looks, axes } = data;
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

  // ---- the map ----
  const map = byId("map");
  const shows = {};
  const options = [
    ["particles", "particles", frames.some((f) => f.particles.length > 1)], ["ellipses", "ellipses", true],
    ["detections", "detections", true], ["missed", "missed", true], ["labels", "labels", false],
    ["truth", "truth", series.truth.some((p) => p)], ["reckoned", "dead reckoning", false], ["landmarks", "true landmarks", data.landmarks.length > 0],
    ["follow", "follow", false],
  ];
  const absent = {
    particles: !frames.some((f) => f.particles.length > 1), truth: !series.truth.some((p) => p), landmarks: data.landmarks.length === 0,
  };
  for (const [name, text, on] of options) {
    if (absent[name]) continue;
    const label = make("label", byId("shows"));
    const box = make("input", label);
    box.type = "checkbox";
    box.checked = on;
    label.append(" " + text);
    shows[name] = box;
    box.addEventListener("change", drawMap);
  }
  let look = looks[0];
  if (looks.length > 1) {
    const label = make("label", byId("shows"), "from ");
    const choice = make("select", label);
    looks.forEach((pair, k) => {
      make("option", choice, k === 0 ? "above" : "the side (" + pair.map((axis) => axes[axis]).join(", ") + ")").value = k;
    });
    choice.addEventListener("change", () => { look = looks[choice.value]; showAll(); });
  }
  const on = (name) => shows[name] !== undefined && shows[name].checked;

  let current = frames.length - 1;
  let view = { x: 0, y: 0, scale: 1 };
  // The ways and the true landmarks; of an estimated map all but strays: one false feature far away would make all else small.
  const showAll = () => {
    const points = [...series.position, ...series.truth.filter(Boolean), ...data.landmarks];
    const last = frames[frames.length - 1];
    const features = last ? last.features.map((feature) => feature[2]) : [];
    const span = (axis) => {
      let [low, high] = [Infinity, -Infinity];
      for (const p of points) { low = Math.min(low, p[axis]); high = Math.max(high, p[axis]); }
      const sorted = features.map((p) => p[axis]).sort((a, b) => a - b);
      const at = (share) => sorted[Math.round(share * (sorted.length - 1))];
      if (sorted.length > 0) [low, high] = [Math.min(low, at(0.02)), Math.max(high, at(0.98))];
      const margin = 0.04 * (high - low) + 0.5;
      return [low - margin, high + margin];
    };
    const rect = map.getBoundingClientRect();
    const [[x0, x1], [y0, y1]] = look.map(span);
    view = { x: (x0 + x1) / 2, y: (y0 + y1) / 2, scale: Math.min(rect.width / (x1 - x0), rect.height / (y1 - y0)) };
    drawMap();
  };

  function drawMap() {
    const [c, width, height] = context(map);
    const [i, j] = look;
    const frame = frames[current];
    if (!frame) return;
    if (on("follow")) [view.x, view.y] = [frame.pose[i], frame.pose[j]];
    const X = (p) => width / 2 + (p[i] - view.x) * view.scale;
    const Y = (p) => height / 2 - (p[j] - view.y) * view.scale;
    grid(c, width, height);
    const path = (points, until, colour, dash) => {
      c.strokeStyle = colour;
      c.lineWidth = 1.5;
      c.setLineDash(dash);
      c.beginPath();
      let pen = false;
      for (let k = 0; k < until; k++) {
        const p = points[k];
        if (!p) { pen = false; continue; }
        if (pen) c.lineTo(X(p), Y(p)); else c.moveTo(X(p), Y(p));
        pen = true;
      }
      c.stroke();
      c.setLineDash([]);
    };
    let until = series.scan.findIndex((scan) => scan > frame.scan);
    if (until < 0) until = series.scan.length;
    const n = axes.length;
    // Of the upper triangle of a covariance, row by row: the ellipse that holds 95 % in this look.
    const entry = (row, column) => row * n - row * (row - 1) / 2 + column - row;
    const ellipse = (at, covariance, colour) => {
      const [a, b, d] = [covariance[entry(i, i)], covariance[entry(i, j)], covariance[entry(j, j)]];
      const middle = (a + d) / 2, off = Math.hypot((a - d) / 2, b);
      const axesLength = [middle + off, Math.max(0, middle - off)].map((v) => Math.sqrt(5.991 * v) * view.scale);
      c.strokeStyle = colour;
      c.lineWidth = 1;
      c.beginPath();
      c.ellipse(X(at), Y(at), axesLength[0], axesLength[1], -Math.atan2(2 * b, a - d) / 2, 0, 2 * Math.PI);
      c.stroke();
    };
    const mark = (at, colour, size, shape, filled = true) => {
      const [x, y] = [X(at), Y(at)];
      if (x < -20 || y < -20 || x > width + 20 || y > height + 20) return;
      c.strokeStyle = c.fillStyle = colour;
      c.lineWidth = 1.4;
      c.beginPath();
      if (shape === "cross") {
        c.moveTo(x - size, y - size); c.lineTo(x + size, y + size);
        c.moveTo(x - size, y + size); c.lineTo(x + size, y - size);
        c.stroke();
      } else if (shape === "plus") {
        c.moveTo(x - size, y); c.lineTo(x + size, y);
        c.moveTo(x, y - size); c.lineTo(x, y + size);
        c.stroke();
      } else {
        c.arc(x, y, size, 0, 2 * Math.PI);
        if (filled) c.fill(); else c.stroke();
      }
    };
    if (on("landmarks")) data.landmarks.forEach((p) => mark(p, colours.landmark, 5, "plus"));
    if (on("reckoned")) path(series.dead_reckoning, until, colours.reckoned, [5, 4]);
    if (on("truth")) path(series.truth, until, colours.truth, [2, 3]);
    path(series.position, until, colours.estimate, []);
    if (on("detections")) {
      for (const [at, known] of frame.detections) mark(at, known ? colours.hit : colours.stray, known ? 3 : 4, known ? "dot" : "cross");
    }
    const drawFeature = (id, at, covariance, fate, colour) => {
      if (on("ellipses")) ellipse(at, covariance, colour);
      mark(at, colour, 2.5, "dot");
      if (fate < 0 && on("missed")) mark(at, colours.missed, 7, "ring", false);
      if (on("labels")) { c.fillStyle = colours.ink; c.fillText(id, X(at) + 6, Y(at) - 5); }
    };
    for (const [id, , at, covariance, fate] of frame.features) drawFeature(id, at, covariance, fate, colours.static);
    for (const at of frame.movers) mark(at, colours.moving, 7, "plus");
    for (const [id, , at, covariance, velocity, fate] of frame.moving) {
      drawFeature("m" + id, at, covariance, fate, colours.moving);
      c.strokeStyle = colours.moving;
      c.beginPath();
      c.moveTo(X(at), Y(at));
      c.lineTo(X(at) + velocity[i] * view.scale, Y(at) - velocity[j] * view.scale);
      c.stroke();
    }
    if (on("particles") && frame.particles.length > 1) {
      const most = frame.particles[0][n];
      for (const particle of frame.particles) {
        c.globalAlpha = 0.25 + 0.75 * particle[n] / (most || 1);
        mark(particle, colours.particle, 2, "dot");
      }
      c.globalAlpha = 1;
    }
    if (on("truth") && frame.truth) mark(frame.truth, colours.truth, 5, "ring", false);
    if (on("ellipses")) ellipse(frame.pose, frame.covariance, colours.estimate);
    // The vehicle: an arrow of a fixed size along its heading.
    const [x, y] = [X(frame.pose), Y(frame.pose)];
    const heading = i === 0 && j === 1 ? frame.pose[n] : 0;
    c.fillStyle = colours.estimate;
    c.save();
    c.translate(x, y);
    c.rotate(-heading);
    c.beginPath();
    c.moveTo(11, 0); c.lineTo(-7, 6); c.lineTo(-4, 0); c.lineTo(-7, -6);
    c.closePath();
    c.fill();
    c.restore();
  }

  function grid(c, width, height) {
    c.strokeStyle = colours.line;
    c.fillStyle = colours.faint;
    c.lineWidth = 1;
    const [i, j] = look;
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
    c.fillText(axes[i] + " (m) to the right, " + axes[j] + " (m) upwards", width - 8, 15);
    c.textAlign = "left";
  }

  // ---- time ----
  const slider = byId("time");
  slider.max = Math.max(0, frames.length - 1);
  const nearest = (t) => {
    let best = 0;
    frames.forEach((frame, k) => { if (Math.abs(frame.t_s - t) < Math.abs(frames[best].t_s - t)) best = k; });
    return best;
  };
  const go = (k) => {
    current = Math.max(0, Math.min(frames.length - 1, k));
    slider.value = current;
    const frame = frames[current];
    if (!frame) return;
    byId("clock").textContent = "scan " + frame.scan + ", " + frame.t_s.toFixed(2) + " s";
    const row = series.scan.findIndex((scan) => scan >= frame.scan);
    const met = frame.detections.filter((d) => d[1]).length;
    const missed = frame.features.concat(frame.moving).filter((f) => f[f.length - 1] < 0).length;
    const error = frame.truth ? Math.hypot(...frame.truth.map((x, k) => x - frame.pose[k])) : null;
    byId("now").textContent = [
      "error " + figure(error, 3) + " m", "2σ " + figure(series.position_2sigma_m[row], 3) + " m",
      frame.features.length + " static and " + frame.moving.length + " moving features",
      frame.detections.length + " detections: " + met + " of known features, " + (frame.detections.length - met) + " unexplained",
      missed + " missed",
    ].join("; ");
    drawMap();
    curves.forEach((draw) => draw());
  };
  let playing = null;
  const play = () => {
    byId("play").textContent = playing ? "\u25b6" : "\u275a\u275a";
    if (playing) { clearInterval(playing); playing = null; return; }
    if (current === frames.length - 1) go(0);
    playing = setInterval(() => { if (current === frames.length - 1) play(); else go(current + 1); }, 80);
  };
  slider.addEventListener("input", () => go(Number(slider.value)));
  byId("play").addEventListener("click", play);

  // ---- fingers, mouse, keys ----
  const fingers = new Map();
  const zoom = (factor, x, y) => {
    const rect = map.getBoundingClientRect();
    const [dx, dy] = [(x - rect.width / 2) / view.scale, (rect.height / 2 - y) / view.scale];
    view.x += dx - dx / factor;
    view.y += dy - dy / factor;
    view.scale *= factor;
    drawMap();
  };
  map.addEventListener("pointerdown", (e) => { map.setPointerCapture(e.pointerId); fingers.set(e.pointerId, [e.offsetX, e.offsetY]); });
  map.addEventListener("pointermove", (e) => {
    const before = fingers.get(e.pointerId);
    if (!before) return;
    const now = [e.offsetX, e.offsetY];
    if (fingers.size === 1) {
      if (shows.follow) shows.follow.checked = false;
      view.x -= (now[0] - before[0]) / view.scale;
      view.y += (now[1] - before[1]) / view.scale;
      drawMap();
    } else if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== e.pointerId)[1];
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      if (apart(before) > 0) zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    }
    fingers.set(e.pointerId, now);
  });
  for (const end of ["pointerup", "pointercancel"]) map.addEventListener(end, (e) => fingers.delete(e.pointerId));
  map.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(-e.deltaY / 400), e.offsetX, e.offsetY); }, { passive: false });
  map.addEventListener("dblclick", showAll);
  const centre = () => { const rect = map.getBoundingClientRect(); return [rect.width / 2, rect.height / 2]; };
  const keys = {
    ArrowRight: () => go(current + 1), ArrowLeft: () => go(current - 1), Home: () => go(0), End: () => go(frames.length - 1),
    PageDown: () => go(current + 20), PageUp: () => go(current - 20),
    " ": play, "+": () => zoom(1.25, ...centre()), "-": () => zoom(0.8, ...centre()), 0: showAll,
    f: () => { shows.follow.checked = !shows.follow.checked; drawMap(); }, t: () => byId("theme").click(),
  };
  document.addEventListener("keydown", (e) => {
    const focused = document.activeElement;
    const elsewhere = focused && ["SELECT", "BUTTON"].includes(focused.tagName);
    const onSlider = focused === slider && e.key !== " ";
    const scrolls = ["PageDown", "PageUp", "Home", "End", " "].includes(e.key) && focused !== map && focused !== slider;
    if (e.ctrlKey || e.metaKey || e.altKey || elsewhere || onSlider || scrolls || !keys[e.key]) return;
    e.preventDefault();
    keys[e.key]();
  });
  byId("theme").addEventListener("click", () => {
    setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
    drawMap();
    curves.forEach((draw) => draw());
  });

  // ---- curves ----
  const curves = [];
  const heading = series.heading_error_deg.some((v) => v !== null);
  const error = series.position_error_m.some((v) => v !== null);
  const plots = [
    error && ["position (m)", [["error", "position_error_m", "estimate"], ["the filter's own 2σ", "position_2sigma_m", "missed"],
      ["error of dead reckoning", "dead_reckoning_error_m", "reckoned"]]],
    !error && ["position (m)", [["the filter's own 2σ", "position_2sigma_m", "missed"]]],
    heading ? ["heading (deg)", [["error", "heading_error_deg", "estimate"], ["the filter's own 2σ", "heading_2sigma_deg", "missed"]]]
      : ["heading (deg)", [["the filter's own 2σ", "heading_2sigma_deg", "missed"]]],
    series.ospa_m.some((v) => v !== null) && ["OSPA of the map (m)", [["OSPA", "ospa_m", "estimate"]]],
    ["features and measurements", [["features estimated", "features_estimated", "static"], ["measurements", "measurements", "faint"],
      ["in view", "in_view", "moving"]]],
    series.n_eff.some((v) => v > 1) && ["effective particles", [["N_eff", "n_eff", "particle"]]],
    series.pages_used.some((v) => v !== null) && ["pages of the pool in use", [["pages", "pages_used", "particle"]]],
    ["time of a scan (µs)", [["time", "scan_us", "estimate"]]],
  ].filter(Boolean);
  for (const [name, lines] of plots) {
    const head = make("div", byId("curves"));
    head.className = "curve-name";
    make("b", head, name);
    const hidden = new Set();
    for (const [text, key, colour] of lines) {
      const label = make("label", head);
      const box = make("input", label);
      box.type = "checkbox";
      // Dead reckoning would often leave all else flat on the ground.
      box.checked = key !== "dead_reckoning_error_m";
      if (!box.checked) hidden.add(key);
      const swatch = make("i", label);
      swatch.style.background = "var(--" + colour + ")";
      label.append(text);
      box.addEventListener("change", () => { if (box.checked) hidden.delete(key); else hidden.add(key); draw(); });
    }
    const read = make("span", head);
    read.className = "faint";
    const canvas = make("canvas", byId("curves"));
    canvas.className = "curve";
    const left = 56, bottom = 20;
    const times = series.t_s;
    const [t0, t1] = [times[0] ?? 0, Math.max(times[times.length - 1] ?? 1, (times[0] ?? 0) + 1e-6)];
    const draw = () => {
      const [c, width, height] = context(canvas);
      const shown = lines.filter(([, key]) => !hidden.has(key));
      let high = 0;
      for (const [, key] of shown) for (const v of series[key]) if (v !== null && v > high) high = v;
      high = high > 0 ? 1.05 * high : 1;
      const X = (t) => left + (t - t0) / (t1 - t0) * (width - left - 8);
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
      for (const [, key, colour] of shown) {
        c.strokeStyle = colours[colour];
        c.lineWidth = 1.3;
        c.beginPath();
        const values = series[key];
        let pen = false;
        values.forEach((v, k) => {
          if (v === null) { pen = false; return; }
          if (pen) c.lineTo(X(times[k]), Y(v)); else c.moveTo(X(times[k]), Y(v));
          pen = true;
        });
        c.stroke();
        // What is known at single scans alone.
        c.fillStyle = colours[colour];
        values.forEach((v, k) => {
          const alone = v !== null && (values[k - 1] ?? null) === null && (values[k + 1] ?? null) === null;
          if (alone) c.fillRect(X(times[k]) - 2, Y(v) - 2, 4, 4);
        });
      }
      const frame = frames[current];
      if (!frame) return;
      c.strokeStyle = colours.ink;
      c.beginPath();
      c.moveTo(X(frame.t_s), 0);
      c.lineTo(X(frame.t_s), height - bottom);
      c.stroke();
      const row = series.scan.findIndex((scan) => scan >= frame.scan);
      read.textContent = shown.map(([text, key]) => text + " " + figure(series[key][row], 3)).join(", ");
    };
    let held = false;
    const pick = (e) => go(nearest(t0 + (e.offsetX - left) / (canvas.getBoundingClientRect().width - left - 8) * (t1 - t0)));
    canvas.addEventListener("pointerdown", (e) => { held = true; pick(e); });
    canvas.addEventListener("pointermove", (e) => { if (held) pick(e); });
    for (const end of ["pointerup", "pointercancel", "pointerleave"]) canvas.addEventListener(end, () => { held = false; });
    curves.push(draw);
  }

  // ---- texts ----
  const tiles = [
    ["position_rmse_m", "position RMSE (m)"], ["dead_reckoning_rmse_m", "dead reckoning RMSE (m)"], ["heading_rmse_deg", "heading RMSE (deg)"],
    ["nees_median", "NEES/dim, median"], ["ospa_m", "OSPA of the final map (m)"], ["features_estimated", "features"],
    ["scans", "scans"], ["scan_us_mean", "scan, mean (µs)"],
  ];
  for (const [key, text] of tiles) {
    if (summary[key] === null || summary[key] === undefined) continue;
    const tile = make("div", byId("headline"));
    tile.className = "tile";
    make("b", tile, figure(summary[key]));
    make("span", tile, text);
  }
  if (summary.worse_than_dead_reckoning) {
    const tile = make("div", byId("headline"));
    tile.className = "tile";
    make("b", tile, "worse than dead reckoning").style.color = "var(--stray)";
  }
  const meanings = new Map(data.meanings);
  for (const [key, value] of Object.entries(summary)) {
    if (key === "settings") continue;
    const row = make("tr", byId("figures").tBodies[0]);
    make("td", row, key);
    // As written: every digit of the JSON output.
    make("td", row, value === null ? "-" : String(value)).className = "number";
    make("td", row, meanings.get(key) ?? "");
  }
  byId("settings").textContent = data.settings_text;
  for (const note of data.notes) make("li", byId("notes"), note);
  const entries = [
    ["estimate", "estimate", true], ["truth", "truth", !absent.truth], ["dead reckoning", "reckoned", true], ["static feature", "static", true],
    ["moving feature, its velocity, and + a true one", "moving", frames.some((f) => f.moving.length + f.movers.length > 0)],
    ["missed", "missed", true], ["detection of a known feature", "hit", true], ["unexplained detection", "stray", true],
    ["particle", "particle", !absent.particles], ["true landmark", "landmark", !absent.landmarks],
  ];
  for (const [name, colour] of entries.filter(([, , there]) => there)) {
    const item = make("span", byId("key"));
    make("i", item).style.background = "var(--" + colour + ")";
    item.append(name);
  }
  if (data.health.length === 0) {
    make("p", byId("health"), "Good in all scans.").className = "good";
  } else {
    const wide = make("div", byId("health"));
    wide.className = "wide";
    const table = make("table", wide);
    const titles = make("tr", make("thead", table));
    for (const title of ["condition", "scans", "when", "cause", "what to do"]) make("th", titles, title);
    const body = make("tbody", table);
    for (const reported of data.health) {
      const row = make("tr", body);
      make("td", row, reported.name);
      make("td", row, reported.scans).className = "number";
      const when = make("td", row);
      for (const [, , from, to] of reported.spells.slice(0, 12)) {
        const button = make("button", when, from === to ? from.toFixed(1) + " s" : from.toFixed(1) + " to " + to.toFixed(1) + " s");
        button.addEventListener("click", () => { go(nearest(from)); map.scrollIntoView({ block: "center" }); });
      }
      if (reported.spells.length > 12) when.append(" and " + (reported.spells.length - 12) + " more spells");
      make("td", row, reported.cause ?? "");
      make("td", row, reported.action ?? "");
    }
  }

  // `#t=12.5` begins there, `#theme=dark` in that theme: a link can show what is meant.
  const asked = new URLSearchParams(location.hash.slice(1));
  if (["dark", "light"].includes(asked.get("theme"))) setTheme(asked.get("theme"));
  addEventListener("resize", () => { drawMap(); curves.forEach((draw) => draw()); });
  showAll();
  go(asked.has("t") ? nearest(Number(asked.get("t"))) : frames.length - 1);
  document.documentElement.dataset.ready = Math.round(performance.now());
})();
