#pragma once

#include "view/colours.h"

#include <cairo.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace pcl_gpu_icp::view {

/// \param share of the second
Colour between(Colour a, Colour b, double share);

/// A picture that is drawn, in pixels from the upper left corner.
class Canvas {
public:
  Canvas(int width, int height, Colour background);

  void fill(double x, double y, double width, double height, Colour colour, double opacity = 1);
  void frame(double x, double y, double width, double height, Colour colour);
  /// A filled box with round corners.
  void pill(double x, double y, double width, double height, Colour colour);
  void line(double from_x, double from_y, double to_x, double to_y, double width, Colour colour);
  void dashes(double from_x, double from_y, double to_x, double to_y, Colour colour);
  /// Fills what is below a line through the points, down to `base`, and draws the line.
  void area(const std::vector<std::pair<double, double>>& points, double base, Colour colour, double opacity);

  struct Font {
    double size = 18;
    Colour colour = 0x1b1f24;
    bool bold = false;
  };
  /// Where the text's anchor is: its left end, middle or right end.
  enum class Anchor { Left, Middle, Right };
  /// \param y of the line that the letters stand on
  void text(double x, double y, const std::string& line, const Font& font, Anchor anchor = Anchor::Left);
  double widthOf(const std::string& line, const Font& font);
  /// The line, or as much of its beginning and end as there is room for.
  std::string shortened(const std::string& line, double width, const Font& font);
  /// Lines no wider than that, broken at blanks.
  std::vector<std::string> wrapped(const std::string& text, double width, const Font& font);

  struct Paint {
    Colour colour = 0;
    double opacity = 0;
  };
  /// Each pixel of a box within the picture.
  void paint(int x, int y, int width, int height, const std::function<Paint(int column, int row)>& paint_of);

  /// As a file.
  /// \throws std::runtime_error where memory is out
  std::string png() const;

private:
  struct Free {
    void operator()(cairo_t* context) const;
    void operator()(cairo_surface_t* surface) const;
  };
  void use(Colour colour, double opacity = 1);
  void use(const Font& font);

  std::unique_ptr<cairo_surface_t, Free> surface_;
  std::unique_ptr<cairo_t, Free> context_;
};

} // namespace pcl_gpu_icp::view
