"use strict";
(async () => {
  const byId = (id) => document.getElementById(id);
  // Conditions in the order of their bits.
  const HEALTH = ["UNEXPLAINED_SCAN", "DEGENERATE", "PRUNING_TIGHTENED", "MAP_NOT_UPDATED", "COMPONENTS_LOST", "COVARIANCE_REPAIRED",
    "POSE_REJECTED", "INNOVATION_HIGH", "PREDICTION_REFUSED", "DIVERGENCE_SUSPECTED", "LOST", "INPUT_LOST", "STATE_REPAIRED",
    "CLUTTER_HIGH", "DETECTIONS_LOW"];
  const INTERVAL_S = 0.05;
  const HISTORY = 1200;
  const PLACE_M = [47, 34];

  const bytes = Uint8Array.from(atob(MODULE), (c) => c.charCodeAt(0));
  // It asks for nothing: all that it can do is compute.
  const { instance } = await WebAssembly.instantiate(bytes, {});
  const core = instance.exports;
  const digest = () => BigInt.asUintN(64, core.digest()).toString(16).padStart(16, "0");

  // ---- what the module shows; the order is that of view.rs ----
  const look = () => {
    const n = new Float32Array(core.memory.buffer, core.view(), core.numbers());
    if (n.length === 0) return null;
    let at = 26;
    const list = (count, width) => Array.from({ length: count }, () => n.slice(at, at += width));
    return {
      scans: n[0], t: n[1], pose: n.slice(2, 5), covariance: n.slice(5, 9), truth: n.slice(9, 12), reckoned: n.slice(12, 15), nEff: n[15],
      pages: [n[22], n[23]], range: n[24], health: n[25],
      particles: list(n[16], 4), features: list(n[17], 7), moving: list(n[18], 9), detections: list(n[19], 3), landmarks: list(n[20], 2),
      walkers: list(n[21], 2),
    };
  };

  // ---- colours ----
  let colours = {};
  const setTheme = (theme) => {
    document.documentElement.dataset.theme = theme;
    const style = getComputedStyle(document.documentElement);
    for (const name of ["paper", "ink", "faint", "line", "tile", "estimate", "truth", "reckoned", "static", "moving", "hit", "stray",
      "particle", "landmark"]) colours[name] = style.getPropertyValue("--" + name).trim();
    byId("key").replaceChildren(...[["estimate", "vehicle, as estimated"], ["particle", "particles"], ["static", "features"],
      ["moving", "moving features"], ["hit", "detections of something"], ["stray", "false detections"], ["truth", "the true way"],
      ["reckoned", "odometry alone"], ["landmark", "true landmarks and walkers"]].map(([name, text]) => {
      const item = document.createElement("span");
      const mark = document.createElement("i");
      mark.style.background = colours[name];
      item.append(mark, text);
      return item;
    }));
  };
  setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  const other = () => { setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"); draw(); };
  byId("theme").addEventListener("click", other);

  // ---- the drive ----
  let seen = null;
  let ways = { estimate: [], truth: [], reckoned: [] };
  let history = [];
  let costs = [];
  let running = true;
  const number = (id) => Number(byId(id).value);
  const start = () => {
    const seed = Math.min(4294967295, Math.max(0, Math.round(number("seed")) || 0));
    core.start(seed, number("particles"));
    seen = null;
    ways = { estimate: [], truth: [], reckoned: [] };
    history = [];
    costs = [];
  };
  const keys = new Set();
  let stick = null;
  const wish = () => {
    const pressed = (...names) => names.some((name) => keys.has(name)) ? 1 : 0;
    const along = pressed("arrowup", "w") - pressed("arrowdown", "s");
    const aside = pressed("arrowleft", "a") - pressed("arrowright", "d");
    if (along !== 0 || aside !== 0) return [6 * along, 1.1 * aside];
    if (stick) return [Math.max(-6, Math.min(8, -stick.dy / 12)), Math.max(-1.2, Math.min(1.2, -stick.dx / 60))];
    return [0, 0];
  };
  const step = (automatic, [speed, rate], clutter, detection, told) => {
    const begun = performance.now();
    if (core.step(automatic ? 1 : 0, speed, rate, clutter, detection, told ? 1 : 0) !== 0) throw new Error("the module has refused a step");
    costs.push(performance.now() - begun);
    if (costs.length > 120) costs.shift();
  };
  const meanCost = () => costs.reduce((sum, cost) => sum + cost, 0) / costs.length;
  const note = () => {
    seen = look();
    const { estimate, truth, reckoned } = ways;
    estimate.push(seen.pose);
    truth.push(seen.truth);
    reckoned.push(seen.reckoned);
    for (const way of [estimate, truth, reckoned]) if (way.length > HISTORY) way.shift();
    const off = (p) => Math.hypot(p[0] - seen.truth[0], p[1] - seen.truth[1]);
    history.push([off(seen.pose), 2 * Math.sqrt(seen.covariance[0] + seen.covariance[2]), off(seen.reckoned)]);
    if (history.length > HISTORY) history.shift();
  };
  const advance = () => {
    step(byId("automatic").checked, wish(), number("clutter"), number("detection"), byId("told").checked);
    note();
  };

  // ---- the picture ----
  const map = byId("map");
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
  function draw() {
    const [c, width, height] = context(map);
    if (!seen) return;
    const follow = byId("follow").checked;
    const scale = follow ? Math.min(width, height) / 56 : Math.min(width / (2 * PLACE_M[0]), height / (2 * PLACE_M[1]));
    const middle = follow ? seen.pose : [0, 0];
    const X = (p) => width / 2 + (p[0] - middle[0]) * scale;
    const Y = (p) => height / 2 - (p[1] - middle[1]) * scale;
    const circle = (p, radius, fill) => {
      c.beginPath();
      c.arc(X(p), Y(p), radius, 0, 2 * Math.PI);
      if (fill) c.fill(); else c.stroke();
    };
    const cross = (p, size, upright) => {
      const [x, y] = [X(p), Y(p)];
      c.beginPath();
      if (upright) { c.moveTo(x - size, y); c.lineTo(x + size, y); c.moveTo(x, y - size); c.lineTo(x, y + size); }
      else { c.moveTo(x - size, y - size); c.lineTo(x + size, y + size); c.moveTo(x - size, y + size); c.lineTo(x + size, y - size); }
      c.stroke();
    };
    const path = (points, colour, dash) => {
      c.strokeStyle = colour;
      c.lineWidth = 1.5;
      c.setLineDash(dash);
      c.beginPath();
      points.forEach((p, k) => k === 0 ? c.moveTo(X(p), Y(p)) : c.lineTo(X(p), Y(p)));
      c.stroke();
      c.setLineDash([]);
    };
    // What holds 95 %.
    const ellipse = (p, xx, xy, yy) => {
      const mean = (xx + yy) / 2, off = Math.hypot((xx - yy) / 2, xy);
      const [long, short] = [mean + off, Math.max(0, mean - off)].map((v) => Math.sqrt(5.991 * v) * scale);
      c.beginPath();
      c.ellipse(X(p), Y(p), long, short, -Math.atan2(2 * xy, xx - yy) / 2, 0, 2 * Math.PI);
      c.stroke();
    };
    c.lineWidth = 1;
    c.strokeStyle = colours.line;
    c.strokeRect(X([-45, 0]), Y([0, 32]), 90 * scale, 64 * scale);
    circle(seen.pose, seen.range * scale, false);
    const truth = byId("truth").checked;
    if (truth) {
      c.lineWidth = 1.2;
      c.strokeStyle = colours.landmark;
      seen.landmarks.forEach((p) => cross(p, 4, true));
      seen.walkers.forEach((p) => circle(p, 6, false));
      path(ways.reckoned, colours.reckoned, [5, 4]);
      path(ways.truth, colours.truth, [2, 3]);
    }
    path(ways.estimate, colours.estimate, []);
    c.lineWidth = 1.3;
    for (const p of seen.detections) {
      if (p[2] === 0) { c.strokeStyle = colours.stray; cross(p, 3.5, false); }
      else { c.fillStyle = colours.hit; circle(p, 2.4, true); }
    }
    c.strokeStyle = c.fillStyle = colours.static;
    c.lineWidth = 1.2;
    for (const f of seen.features) {
      c.globalAlpha = 0.35 + 0.65 * Math.min(1, f[5]);
      ellipse(f, f[2], f[3], f[4]);
      circle(f, 1.8, true);
    }
    c.strokeStyle = c.fillStyle = colours.moving;
    for (const f of seen.moving) {
      c.globalAlpha = 0.35 + 0.65 * Math.min(1, f[5]);
      ellipse(f, f[2], f[3], f[4]);
      circle(f, 1.8, true);
      c.beginPath();
      c.moveTo(X(f), Y(f));
      c.lineTo(X(f) + f[7] * scale, Y(f) - f[8] * scale);
      c.stroke();
    }
    c.fillStyle = colours.particle;
    for (const p of seen.particles) {
      c.globalAlpha = 0.3 + 0.7 * Math.min(1, p[3] * 8);
      circle(p, 1.6, true);
    }
    c.globalAlpha = 1;
    c.strokeStyle = colours.estimate;
    ellipse(seen.pose, seen.covariance[0], seen.covariance[1], seen.covariance[2]);
    const vehicle = (pose, fill) => {
      c.save();
      c.translate(X(pose), Y(pose));
      c.rotate(-pose[2]);
      c.beginPath();
      c.moveTo(12, 0); c.lineTo(-7, 6.5); c.lineTo(-4, 0); c.lineTo(-7, -6.5);
      c.closePath();
      if (fill) c.fill(); else c.stroke();
      c.restore();
    };
    if (truth) { c.strokeStyle = colours.truth; vehicle(seen.truth, false); }
    c.fillStyle = colours.estimate;
    vehicle(seen.pose, true);
    if (stick) {
      c.strokeStyle = colours.ink;
      c.lineWidth = 2;
      c.beginPath();
      c.moveTo(stick.x, stick.y);
      c.lineTo(stick.x + stick.dx, stick.y + stick.dy);
      c.arc(stick.x + stick.dx, stick.y + stick.dy, 10, 0, 2 * Math.PI);
      c.stroke();
    }
    drawErrors();
  }
  function drawErrors() {
    const [c, width, height] = context(byId("errors"));
    // Odometry leaves the picture: the filter is what there is to see.
    const top = Math.max(0.5, ...history.map((row) => 1.3 * Math.max(row[0], row[1])));
    const X = (k) => 34 + (width - 40) * (k + HISTORY - history.length) / (HISTORY - 1);
    const Y = (m) => height - 8 - (height - 20) * Math.min(m, 1.1 * top) / top;
    c.fillStyle = colours.faint;
    c.strokeStyle = colours.line;
    for (const m of [0, top / 2, top]) {
      c.fillText(m.toFixed(1) + " m", 2, Y(m) + 4);
      c.beginPath(); c.moveTo(34, Y(m)); c.lineTo(width - 6, Y(m)); c.stroke();
    }
    if (history.length < 2) return;
    c.fillStyle = colours.estimate;
    c.globalAlpha = 0.18;
    c.beginPath();
    c.moveTo(X(0), Y(0));
    history.forEach((row, k) => c.lineTo(X(k), Y(row[1])));
    c.lineTo(X(history.length - 1), Y(0));
    c.fill();
    c.globalAlpha = 1;
    for (const [which, colour] of [[2, colours.reckoned], [0, colours.estimate]]) {
      c.strokeStyle = colour;
      c.lineWidth = 1.5;
      c.beginPath();
      history.forEach((row, k) => k === 0 ? c.moveTo(X(k), Y(row[which])) : c.lineTo(X(k), Y(row[which])));
      c.stroke();
    }
  }

  // ---- the figures beside it ----
  const write = (frames) => {
    if (!seen) return;
    const [off, , reckoned] = history[history.length - 1];
    const texts = {
      digest: digest(), scans: String(seen.scans), error: off.toFixed(2) + " m, " + reckoned.toFixed(2) + " m",
      neff: seen.particles.length ? seen.nEff.toFixed(1) + " of " + seen.particles.length : "-", pages: seen.pages.join(" of "),
      features: seen.features.length + " of " + seen.landmarks.length, moving: seen.moving.length + " of " + seen.walkers.length,
      cost: meanCost().toFixed(2) + " ms",
      health: HEALTH.filter((_, bit) => seen.health >> bit & 1).join(", ") || "good",
      now: seen.t.toFixed(1) + " s; " + seen.detections.length + " detections, " + seen.detections.filter((d) => d[2] === 0).length + " of them false; state " + digest(),
    };
    if (frames !== null) texts.frames = frames.toFixed(0);
    for (const [id, text] of Object.entries(texts)) if (byId(id).textContent !== text) byId(id).textContent = text;
  };

  // ---- controls ----
  const showSliders = () => {
    byId("clutter-now").value = byId("clutter").value;
    byId("detection-now").value = Number(byId("detection").value).toFixed(2);
  };
  for (const id of ["clutter", "detection"]) byId(id).addEventListener("input", showSliders);
  for (const id of ["particles", "seed"]) byId(id).addEventListener("change", start);
  for (const id of ["truth", "follow"]) byId(id).addEventListener("change", draw);
  byId("again").addEventListener("click", start);
  const pause = () => { running = !running; byId("run").textContent = running ? "pause" : "go on"; };
  byId("run").addEventListener("click", pause);
  const DRIVING = ["arrowup", "arrowdown", "arrowleft", "arrowright", "w", "a", "s", "d"];
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("input:not([type=checkbox]), select")) return;
    const key = event.key.toLowerCase();
    if (DRIVING.includes(key)) {
      keys.add(key);
      byId("automatic").checked = false;
      event.preventDefault();
    } else if (key === " " && !event.target.matches("button, input")) { pause(); event.preventDefault(); }
    else if (key === "r") start();
    else if (key === "t") other();
  });
  addEventListener("keyup", (event) => keys.delete(event.key.toLowerCase()));
  addEventListener("blur", () => keys.clear());
  map.addEventListener("pointerdown", (event) => {
    map.setPointerCapture(event.pointerId);
    stick = { x: event.offsetX, y: event.offsetY, dx: 0, dy: 0 };
    byId("automatic").checked = false;
  });
  map.addEventListener("pointermove", (event) => {
    if (stick) [stick.dx, stick.dy] = [event.offsetX - stick.x, event.offsetY - stick.y];
  });
  for (const name of ["pointerup", "pointercancel"]) map.addEventListener(name, () => { stick = null; });
  addEventListener("resize", draw);

  // ---- for a check without a person: #rehearse=SCANS,EVERY drives as examples/native.rs; #measure=SECONDS counts frames ----
  const result = (text) => {
    const element = document.createElement("pre");
    element.id = "result";
    element.textContent = text;
    document.body.append(element);
    console.log("scphd result: " + text + " :end");
  };
  const rehearse = (scans, every) => {
    const lines = [];
    for (let k = 0; k < 2 * scans; k++) {
      const scan = k % scans;
      if (scan === 0) {
        byId("particles").value = k === 0 ? "0" : "64";
        start();
      }
      const [clutter, detection] = scan % 300 < 200 ? [5, 0.9] : [15, 0.75];
      step(scan % 200 < 150, [2, 0.5], clutter, detection, scan % 500 < 400);
      note();
      if ((scan + 1) % every === 0) lines.push(scan + 1 + " " + digest());
    }
    draw();
    write(null);
    result(lines.join("; "));
  };
  // One scan to a frame; the first second is warming up.
  const measure = (seconds) => {
    let [begun, frames, busy] = [null, 0, 0];
    const count = (now) => {
      const from = performance.now();
      advance();
      draw();
      write(null);
      if (begun === null && seen.t * 20 >= 60) [begun, frames, busy] = [now, 0, 0];
      else if (begun !== null) { frames++; busy += performance.now() - from; }
      if (begun !== null && now - begun >= 1000 * seconds) {
        const each = busy / frames;
        write(1000 * frames / (now - begun));
        result((1000 * frames / (now - begun)).toFixed(1) + " frames a second, each with a scan of "
          + (seen.particles.length ? seen.particles.length + " particles" : "a joint map") + "; a frame takes " + each.toFixed(2) + " ms, a scan of it " + meanCost().toFixed(2) + " ms");
      } else requestAnimationFrame(count);
    };
    requestAnimationFrame(count);
  };

  const live = () => {
    let [last, owed, frames, since, rate] = [null, 0, 0, null, null];
    const frame = (now) => {
      requestAnimationFrame(frame);
      // A tab that was away does not catch up.
      const passed = last === null ? 0 : Math.min(0.1, (now - last) / 1000);
      last = now;
      if (since === null) since = now;
      frames++;
      if (now - since >= 1000) [rate, frames, since] = [1000 * frames / (now - since), 0, now];
      if (running) owed += passed * number("pace") / INTERVAL_S;
      const due = Math.min(6, Math.floor(owed));
      owed -= due;
      for (let k = 0; k < due; k++) advance();
      draw();
      write(rate);
    };
    requestAnimationFrame(frame);
  };
  showSliders();
  start();
  const [task, words] = location.hash.slice(1).split("=");
  const given = (words || "").split(",").map(Number);
  if (task === "rehearse" && given.length === 2) rehearse(...given);
  else if (task === "measure" && given[0] > 0) measure(given[0]);
  else live();
})().catch((error) => { document.getElementById("now").textContent = "This does not work here: " + error.message; });
