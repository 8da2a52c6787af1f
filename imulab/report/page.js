'use strict';
(function () {
  var coarse = window.matchMedia && window.matchMedia('(pointer: coarse)').matches;
  var shades = {rest: 'rgba(86,180,233,0.16)', dropped: 'rgba(213,94,0,0.30)', gap: 'rgba(0,0,0,0.25)'};
  var groups = {};

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
    graph = new Dygraph(box.querySelector('.live'), rows, {
      labels: [spec.xlabel].concat(spec.labels), colors: spec.colors, ylabel: spec.ylabel, xlabel: spec.xlabel, logscale: spec.log,
      customBars: false, legend: 'always', labelsDiv: box.querySelector('.legend'), interactionModel: model, strokeWidth: 1.2,
      axisLabelFontSize: 12, xLabelHeight: 20, yLabelWidth: 20, gridLineColor: '#e3e6ea', axisLineColor: '#9aa1aa', digitsAfterDecimal: 4,
      highlightCircleSize: 2, animatedZooms: false, underlayCallback: underlay(spec.marks),
      zoomCallback: follow(spec.group, function () { return graph; })
    });
    (groups[spec.group] = groups[spec.group] || []).push(graph);
  }

  document.querySelectorAll('.chart').forEach(draw);
  window.addEventListener('beforeprint', function () {
    document.querySelectorAll('details').forEach(function (part) { part.open = true; });
  });
})();
