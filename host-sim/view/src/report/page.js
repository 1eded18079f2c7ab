"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { summary, series, frames, looks, axes } = data;
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
    view = viewOf(map, look.map(span));
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
    drawGrid(c, width, height, view, look.map((axis) => axes[axis]));
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
  const zoom = movable(map, () => view, drawMap, () => { if (shows.follow) shows.follow.checked = false; });
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
    series.stage_update_us.some((v) => v !== null) && ["of it by stage (µs)", [["move", "stage_predict_us", "moving"], ["weigh", "stage_weigh_us", "estimate"],
      ["select", "stage_resample_us", "truth"], ["update", "stage_update_us", "static"], ["prune and merge", "stage_reduce_us", "missed"]]],
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
    const times = series.t_s;
    const span = [times[0] ?? 0, Math.max(times[times.length - 1] ?? 1, (times[0] ?? 0) + 1e-6)];
    const draw = () => {
      const [c, width, height] = context(canvas);
      const shown = lines.filter(([, key]) => !hidden.has(key));
      const X = drawChart(c, width, height, span, shown.map(([, key, colour]) => [times, series[key], colours[colour]]));
      const frame = frames[current];
      if (!frame) return;
      c.strokeStyle = colours.ink;
      c.beginPath();
      c.moveTo(X(frame.t_s), 0);
      c.lineTo(X(frame.t_s), height - CHART.bottom);
      c.stroke();
      const row = series.scan.findIndex((scan) => scan >= frame.scan);
      read.textContent = shown.map(([text, key]) => text + " " + figure(series[key][row], 3)).join(", ");
    };
    let held = false;
    const pick = (e) => go(nearest(timeAt(canvas, span, e.offsetX)));
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
