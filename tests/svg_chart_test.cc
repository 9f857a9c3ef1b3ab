// Axis ticks against values worked out by hand, and the document's form.
#include "core/image/svg_chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace burin {
namespace {

using testing::DoubleEq;
using testing::HasSubstr;
using testing::Not;
using testing::Pointwise;

int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(SvgChart, LinearTicksAreRound) {
  EXPECT_THAT(AxisTicks(0, 10, false, 5), Pointwise(DoubleEq(), {0., 2., 4., 6., 8., 10.}));
  EXPECT_THAT(AxisTicks(-0.11, 0.12, false, 4), Pointwise(DoubleEq(), {-0.1, 0., 0.1}));
  EXPECT_THAT(AxisTicks(1012, 1033, false, 5), Pointwise(DoubleEq(), {1015., 1020., 1025., 1030.}));
}

TEST(SvgChart, LogTicksAreRound) {
  EXPECT_THAT(AxisTicks(0.9, 80, true, 6), Pointwise(DoubleEq(), {1., 2., 5., 10., 20., 50.}));
  EXPECT_THAT(AxisTicks(0.5, 2e5, true, 6),
              Pointwise(DoubleEq(), {1., 10., 100., 1000., 10000., 100000.}));
  EXPECT_LE(AxisTicks(1e-20, 1e20, true, 6).size(), 7u);
}

TEST(SvgChart, LogAxisIsForPositiveValuesThatSpread) {
  ChartSeries series;
  series.x = {1, 2, 40};
  series.y = {0, 2, 40};
  EXPECT_TRUE(WantsLogAxis({series}, true, 20));
  EXPECT_FALSE(WantsLogAxis({series}, true, 50));
  EXPECT_FALSE(WantsLogAxis({series}, false, 20)) << "a zero cannot be shown";
  EXPECT_FALSE(WantsLogAxis({}, true, 20));
}

TEST(SvgChart, PointsOutsideAnAxisAreLeftOutAndTextIsEscaped) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ChartPage page;
  page.title = "a < b & \"c\"";
  page.names = {"one", "two"};
  ChartPanel panel;
  panel.log_y = true;
  panel.series = {{0, {1, 2, 3, 4}, {1, 0, nan, 100}}, {1, {1}, {nan}}};
  page.panels = {panel};
  const std::string svg = SvgText(page);
  EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; &quot;c&quot;"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_EQ(Count(svg, "<polyline"), 1) << "a curve without a point is not drawn";
  EXPECT_EQ(Count(svg, "<circle"), 3) << "two points and the legend";
  EXPECT_EQ(svg, SvgText(page));
}

TEST(SvgChart, CurvesAboveTheFrameAreCutOff) {
  ChartPage page;
  page.names = {"falls", "explodes"};
  ChartPanel panel;
  panel.series = {{0, {0, 1}, {1, 0.5}}, {1, {0, 1}, {1, 100}}};
  page.panels = {panel};
  EXPECT_THAT(SvgText(page), HasSubstr(">100</text>"));
  page.panels[0].max_y = 1.25;
  const std::string svg = SvgText(page);
  EXPECT_THAT(svg, Not(HasSubstr(">100</text>")));
  EXPECT_THAT(svg, HasSubstr(">0.6</text>"));
  EXPECT_EQ(Count(svg, "<polyline"), 2);
  EXPECT_EQ(Count(svg, "<clipPath"), 1);
  EXPECT_EQ(Count(svg, "clip-path=\"url(#panel-"), 1);
}

// A curve of one value, or none, has axes all the same.
TEST(SvgChart, DegenerateRangesAreShown) {
  for (const double value : {0.0, 5.0, -3e8, 1e-12}) {
    ChartPage page;
    page.panels = {ChartPanel()};
    page.panels[0].series = {{0, {value, value}, {value, value}}};
    const std::string svg = SvgText(page);
    EXPECT_THAT(svg, Not(HasSubstr("nan"))) << value;
    EXPECT_THAT(svg, Not(HasSubstr("inf"))) << value;
    EXPECT_EQ(Count(svg, "<circle"), 2) << value;
  }
  ChartPage empty;
  empty.panels = {ChartPanel()};
  EXPECT_THAT(SvgText(empty), HasSubstr("</svg>"));
}

}  // namespace
}  // namespace burin
