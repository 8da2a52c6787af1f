'use strict';
(function () {
  var coarse = window.matchMedia && window.matchMedia('(pointer: coarse)').matches;
  var shades = {rest: 'rgba(86,180,233,0.16)', dropped: 'rgba(213,94,0,0.30)', gap: 'rgba(0,0,0,0.25)', withheld: 'rgba(0,0,0,0.25)'};
  var groups = {}, graphs = [];

  // The color that the style gives a picture's color on this page, light or dark.
  var probe = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  probe.style.display = 'none';
  document.body.appendChild(probe);
  function tone(color) {
    var line = document.createElementNS('http://www.w3.org/2000/svg', 'line');
    line.setAttribute('stroke', color);
    probe.appendChild(line);
    var seen = getComputedStyle(line).stroke;
    line.remove();
    return seen;
  }
  function colors(spec) {
    return {colors: spec.colors.map(tone), gridLineColor: tone('#e3e6ea'), axisLineColor: tone('#9aa1aa')};
  }

  function underlay(marks) {
    return function (canvas, area, g) {
      marks.forEach(function (mark) {
        var left = g.toDomXCoord(mark[0]), right = g.toDomXCoord(mark[1]);
        canvas.fillStyle = shades[mark[2]];
        canvas.fillRect(left, area.y, Math.max(right - left, 1), area.h);
      });
    };
  }

  function follow(group, self) {
    return function (low, high) {
      groups[group].forEach(function (other) {
        if (other !== self()) other.updateOptions({dateWindow: self().isZoomed('x') ? [low, high] : null});
      });
    };
  }

  function draw(box) {
    var spec = JSON.parse(box.querySelector('script').textContent);
    var rows = spec.x.map(function (x, i) {
      return [x].concat(spec.y.map(function (series) { return series[i]; }));
    });
    var model = Object.assign({}, Dygraph.defaultInteractionModel);
    if (coarse) ['touchstart', 'touchmove', 'touchend'].forEach(function (name) { delete model[name]; });
    box.classList.add('drawn');  // before: dygraphs takes the size that its element has now
    var graph;
    graph = new Dygraph(box.querySelector('.live'), rows, Object.assign(colors(spec), {
      labels: [spec.xlabel].concat(spec.labels), ylabel: spec.ylabel, xlabel: spec.xlabel, logscale: spec.log,
      customBars: false, legend: 'always', labelsDiv: box.querySelector('.legend'), interactionModel: model, strokeWidth: 1.2,
      axisLabelFontSize: 12, xLabelHeight: 20, yLabelWidth: 20, digitsAfterDecimal: 4,
      highlightCircleSize: 2, animatedZooms: false, underlayCallback: underlay(spec.marks),
      zoomCallback: follow(spec.group, function () { return graph; })
    }));
    graphs.push([graph, spec]);
    (groups[spec.group] = groups[spec.group] || []).push(graph);
  }

  // What is wider than its place says so, and keys reach it.
  function cue() {
    document.querySelectorAll('.scroll').forEach(function (box) {
      var wider = box.scrollWidth > box.clientWidth + 1;
      box.classList.toggle('wider', wider);
      if (wider) box.setAttribute('tabindex', '0'); else box.removeAttribute('tabindex');
    });
  }

  document.querySelectorAll('.chart').forEach(draw);
  cue();
  window.addEventListener('resize', cue);
  document.querySelectorAll('details').forEach(function (part) { part.addEventListener('toggle', cue); });
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', function () {
    graphs.forEach(function (drawn) { drawn[0].updateOptions(colors(drawn[1])); });
  });
  window.addEventListener('beforeprint', function () {
    document.querySelectorAll('details').forEach(function (part) { part.open = true; });
  });
})();
