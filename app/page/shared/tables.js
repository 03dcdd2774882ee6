// In the place of Bokeh's bundle of tables (302 kB), which the page has no use for. Panel's bundle defines a table as soon
// as it runs, and of that bundle it asks for the class of a table's columns alone.

Bokeh.register_plugin(
  {
    columns(require, _module, exports) {
      exports.TableColumn = class extends require("@bokehjs/model").Model {};
    },
  },
  "columns",
  { "models/widgets/tables/index": "columns" },
);
