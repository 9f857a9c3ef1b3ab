// Line charts as SVG text: a page of panels that share one legend. Written by hand, since a chart of a
// few curves needs no library; the same input gives the same bytes.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace burin {

// A curve; points where x or y is not finite are left out (on a log axis also those not above 0).
struct ChartSeries {
  size_t style = 0;  // which colour, dashes and marker: index into ChartPage::names
  std::vector<double> x;
  std::vector<double> y;
};

struct ChartPanel {
  std::string x_label;
  std::string y_label;
  bool log_x = false;
  bool log_y = false;
  // Where the frame ends; curves that rise above it leave through its top.
  double max_y = std::numeric_limits<double>::infinity();
  std::vector<ChartSeries> series;
};

struct ChartPage {
  std::string title;
  std::string subtitle;
  std::vector<std::string> names;  // of the legend
  std::vector<ChartPanel> panels;  // two a row
};

// The page as a stand-alone SVG document.
std::string SvgText(const ChartPage& page);

// All finite values are above 0 and the largest is more than `factor` times the smallest: a log axis
// shows more than a linear one.
bool WantsLogAxis(const std::vector<ChartSeries>& series, bool of_x, double factor);

// Round values within [low, high], ascending, about `count` of them: multiples of 1, 2 or 5 times a
// power of ten; on a log axis powers of ten, and 2 and 5 times these while they are few.
std::vector<double> AxisTicks(double low, double high, bool log, int count);

}  // namespace burin
