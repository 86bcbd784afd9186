const Plotly = require("plotly.js/lib/core");
Plotly.register([require("plotly.js/lib/heatmap"), require("plotly.js/lib/scatter3d")]);
module.exports = Plotly;
