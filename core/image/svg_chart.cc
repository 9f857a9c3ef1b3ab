#include "core/image/svg_chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

namespace burin {
namespace {

// Of the page, in SVG units (pixels at normal size).
constexpr double kPanelWidth = 520;
constexpr double kPanelHeight = 330;
constexpr double kLeft = 92;  // of a panel, to its frame: a label and ticks such as 1.68e+06
constexpr double kRight = 16;
constexpr double kTop = 14;
constexpr double kBottom = 50;
constexpr double kHeader = 62;
constexpr double kLegendRow = 22;
constexpr double kLegendColumn = 172;
constexpr double kEmptyMargin = 0.04;  // of an axis, beyond the first and the last value
constexpr int kTickCount = 6;

// Told apart by people with colour-blindness as far as eight can be; dashes and markers do the rest.
constexpr std::array<const char*, 8> kColours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                 "#000000", "#e69f00", "#56b4e9", "#8c564b"};
constexpr std::array<const char*, 5> kDashes = {"", "7 3", "2 2.5", "9 3 2 3", "4 2"};

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f", value);
  return text;
}

std::string TickText(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.5g", value);
  return text;
}

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else {
      escaped += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return escaped;
}

std::string Text(double x, double y, const std::string& text, const std::string& attributes) {
  return "<text x=\"" + Number(x) + "\" y=\"" + Number(y) + "\" " + attributes + ">" +
         Escaped(text) + "</text>\n";
}

std::string Line(double x0, double y0, double x1, double y1, const std::string& attributes) {
  return "<line x1=\"" + Number(x0) + "\" y1=\"" + Number(y0) + "\" x2=\"" + Number(x1) +
         "\" y2=\"" + Number(y1) + "\" " + attributes + "/>\n";
}

// A value's place along an axis of the panel.
struct Axis {
  bool log = false;
  double low = 0;   // of the values, after the logarithm
  double high = 1;  // more than low
  double from = 0;  // where low is drawn
  double to = 1;

  double Raw(double value) const { return log ? std::log10(value) : value; }
  bool Shows(double value) const { return std::isfinite(value) && (!log || value > 0); }
  double Place(double value) const {
    return from + (Raw(value) - low) / (high - low) * (to - from);
  }
  double Value(double raw) const { return log ? std::pow(10.0, raw) : raw; }
};

bool Drawn(const Axis& x, const Axis& y, const ChartSeries& series, size_t k) {
  return x.Shows(series.x[k]) && y.Shows(series.y[k]);
}

// Ranges of both axes over the points that are drawn.
void FitAxes(const ChartPanel& panel, Axis* x, Axis* y) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  x->log = panel.log_x;
  y->log = panel.log_y;
  x->low = y->low = kInfinity;
  x->high = y->high = -kInfinity;
  for (const ChartSeries& series : panel.series) {
    for (size_t k = 0; k < series.x.size(); ++k) {
      if (!Drawn(*x, *y, series, k)) continue;
      x->low = std::min(x->low, x->Raw(series.x[k]));
      x->high = std::max(x->high, x->Raw(series.x[k]));
      y->low = std::min(y->low, y->Raw(series.y[k]));
      y->high = std::max(y->high, y->Raw(series.y[k]));
    }
  }
  if (y->Shows(panel.max_y)) y->high = std::min(y->high, y->Raw(panel.max_y));
  for (Axis* axis : {x, y}) {
    if (!(axis->low <= axis->high)) {
      axis->low = 0;  // nothing to show
      axis->high = 1;
    }
    const double magnitude = std::max(std::abs(axis->low), std::abs(axis->high));
    double margin = kEmptyMargin * (axis->high - axis->low);
    if (!(margin > 1e-9 * magnitude)) margin = std::max(0.05 * magnitude, 0.01);
    axis->low -= margin;
    axis->high += margin;
  }
}

std::string Marker(size_t style, double x, double y) {
  const std::string colour = kColours[style % kColours.size()];
  const std::string paint = style % 2 == 0
                                ? "fill=\"" + colour + "\""
                                : "fill=\"white\" stroke=\"" + colour + "\" stroke-width=\"1.2\"";
  constexpr double kSize = 2.6;
  if (style % 3 == 0) {
    return "<circle cx=\"" + Number(x) + "\" cy=\"" + Number(y) + "\" r=\"" + Number(kSize) +
           "\" " + paint + "/>\n";
  }
  if (style % 3 == 1) {
    return "<rect x=\"" + Number(x - kSize) + "\" y=\"" + Number(y - kSize) + "\" width=\"" +
           Number(2 * kSize) + "\" height=\"" + Number(2 * kSize) + "\" " + paint + "/>\n";
  }
  constexpr double kReach = 1.4 * kSize;
  return "<polygon points=\"" + Number(x) + "," + Number(y - kReach) + " " + Number(x + kReach) +
         "," + Number(y + kSize) + " " + Number(x - kReach) + "," + Number(y + kSize) + "\" " +
         paint + "/>\n";
}

std::string Stroke(size_t style) {
  const std::string dashes = kDashes[style % kDashes.size()];
  return std::string("fill=\"none\" stroke=\"") + kColours[style % kColours.size()] +
         "\" stroke-width=\"1.7\"" + (dashes.empty() ? "" : " stroke-dasharray=\"" + dashes + "\"");
}

std::string PanelText(const ChartPanel& panel, double left, double top) {
  Axis x;
  Axis y;
  FitAxes(panel, &x, &y);
  x.from = left + kLeft;
  x.to = left + kPanelWidth - kRight;
  y.from = top + kPanelHeight - kBottom;
  y.to = top + kTop;
  std::string svg;
  for (const double tick : AxisTicks(x.Value(x.low), x.Value(x.high), x.log, kTickCount)) {
    const double place = x.Place(tick);
    svg += Line(place, y.from, place, y.to, "class=\"grid\"");
    svg += Text(place, y.from + 17, TickText(tick), "class=\"tick\" text-anchor=\"middle\"");
  }
  for (const double tick : AxisTicks(y.Value(y.low), y.Value(y.high), y.log, kTickCount)) {
    const double place = y.Place(tick);
    svg += Line(x.from, place, x.to, place, "class=\"grid\"");
    svg += Text(x.from - 7, place + 4, TickText(tick), "class=\"tick\" text-anchor=\"end\"");
  }
  const std::string frame = "<rect x=\"" + Number(x.from) + "\" y=\"" + Number(y.to) +
                            "\" width=\"" + Number(x.to - x.from) + "\" height=\"" +
                            Number(y.from - y.to) + "\"";
  svg += frame + " fill=\"none\" stroke=\"#444\"/>\n";
  svg += Text((x.from + x.to) / 2, y.from + 38, panel.x_label, "text-anchor=\"middle\"");
  const double label_x = left + 14;
  const double label_y = (y.from + y.to) / 2;
  svg += Text(label_x, label_y, panel.y_label,
              "text-anchor=\"middle\" transform=\"rotate(-90 " + Number(label_x) + " " +
                  Number(label_y) + ")\"");
  const std::string clip = "panel-" + Number(left) + "-" + Number(top);
  svg += "<clipPath id=\"" + clip + "\">" + frame + "/></clipPath>\n<g clip-path=\"url(#" + clip +
         ")\">\n";
  for (const ChartSeries& series : panel.series) {
    std::string points;
    std::string markers;
    for (size_t k = 0; k < series.x.size(); ++k) {
      if (!Drawn(x, y, series, k)) continue;
      points += (points.empty() ? "" : " ") + Number(x.Place(series.x[k])) + "," +
                Number(y.Place(series.y[k]));
      markers += Marker(series.style, x.Place(series.x[k]), y.Place(series.y[k]));
    }
    if (points.empty()) continue;
    svg += "<polyline points=\"" + points + "\" " + Stroke(series.style) + "/>\n" + markers;
  }
  return svg + "</g>\n";
}

}  // namespace

std::vector<double> AxisTicks(double low, double high, bool log, int count) {
  std::vector<double> ticks;
  if (log) {
    const double decades = std::log10(high / low);
    const int skip = std::max(1, static_cast<int>(std::ceil(decades / count)));
    for (int power = static_cast<int>(std::floor(std::log10(low)));
         power <= static_cast<int>(std::ceil(std::log10(high))); ++power) {
      if (power % skip != 0) continue;
      for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor > 1 && 3 * decades > 1.5 * count) continue;
        const double tick = factor * std::pow(10.0, power);
        if (tick >= low && tick <= high) ticks.push_back(tick);
      }
    }
    return ticks;
  }
  const double raw = (high - low) / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= raw) step = factor * power;
  }
  for (double k = std::ceil(low / step); k * step <= high; ++k) {
    ticks.push_back(k == 0 ? 0 : k * step);
  }
  return ticks;
}

bool WantsLogAxis(const std::vector<ChartSeries>& series, bool of_x, double factor) {
  double low = std::numeric_limits<double>::infinity();
  double high = 0;
  for (const ChartSeries& one : series) {
    for (const double value : of_x ? one.x : one.y) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  return low > 0 && high > factor * low;
}

std::string SvgText(const ChartPage& page) {
  const size_t rows = (page.panels.size() + 1) / 2;
  const auto columns = static_cast<double>(std::min<size_t>(2, page.panels.size()));
  const double width = std::max(1.0, columns) * kPanelWidth;
  const auto legend_columns =
      std::max<size_t>(1, static_cast<size_t>((width - 20) / kLegendColumn));
  const size_t legend_rows = (page.names.size() + legend_columns - 1) / legend_columns;
  const double legend_top = kHeader + static_cast<double>(rows) * kPanelHeight;
  const double height = legend_top + static_cast<double>(legend_rows) * kLegendRow + 14;
  std::ostringstream svg;
  svg << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
      << "width=\"" << Number(width) << "\" height=\"" << Number(height) << "\" viewBox=\"0 0 "
      << Number(width) << " " << Number(height) << "\">\n"
      << "<style>text{font:13px sans-serif;fill:#222}.tick{font-size:11.5px}"
      << ".grid{stroke:#ddd;stroke-width:1}</style>\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
      << Text(kLeft, 26, page.title, "style=\"font-size:17px;font-weight:bold\"")
      << Text(kLeft, 47, page.subtitle, "style=\"fill:#555\"");
  for (size_t k = 0; k < page.panels.size(); ++k) {
    svg << PanelText(page.panels[k], static_cast<double>(k % 2) * kPanelWidth,
                     kHeader + static_cast<double>(k / 2) * kPanelHeight);
  }
  for (size_t k = 0; k < page.names.size(); ++k) {
    const double x = 20 + static_cast<double>(k % legend_columns) * kLegendColumn;
    const double y = legend_top + 10 + static_cast<double>(k / legend_columns) * kLegendRow;
    svg << Line(x, y, x + 34, y, Stroke(k)) << Marker(k, x + 17, y)
        << Text(x + 41, y + 4, page.names[k], "");
  }
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace burin
