#include "view/canvas.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace pcl_gpu_icp::view {
namespace {

constexpr double pi = 3.14159265358979323846;

double channel(Colour colour, int shift) { return static_cast<double>(colour >> shift & 0xff) / 255; }

void require(cairo_status_t status)
{
  if (status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("cannot draw: ") + cairo_status_to_string(status));
}

bool startsCharacter(char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }

} // namespace

Colour between(Colour a, Colour b, double share)
{
  Colour mixed = 0;
  for (const int shift : {16, 8, 0}) {
    const double from = a >> shift & 0xff, to = b >> shift & 0xff;
    mixed |= static_cast<Colour>(std::lround(from + share * (to - from))) << shift;
  }
  return mixed;
}

void Canvas::Free::operator()(cairo_t* context) const { cairo_destroy(context); }
void Canvas::Free::operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }

Canvas::Canvas(int width, int height, Colour background)
: surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height))
, context_(cairo_create(surface_.get()))
{
  require(cairo_status(context_.get()));
  fill(0, 0, width, height, background);
}

void Canvas::use(Colour colour, double opacity)
{
  cairo_set_source_rgba(context_.get(), channel(colour, 16), channel(colour, 8), channel(colour, 0), opacity);
}

void Canvas::use(const Font& font)
{
  cairo_select_font_face(context_.get(),
                         "sans-serif",
                         CAIRO_FONT_SLANT_NORMAL,
                         font.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(context_.get(), font.size);
  use(font.colour);
}

void Canvas::fill(double x, double y, double width, double height, Colour colour, double opacity)
{
  use(colour, opacity);
  cairo_rectangle(context_.get(), x, y, width, height);
  cairo_fill(context_.get());
}

void Canvas::frame(double x, double y, double width, double height, Colour colour)
{
  use(colour);
  cairo_set_line_width(context_.get(), 1);
  cairo_rectangle(context_.get(), x + 0.5, y + 0.5, width - 1, height - 1);
  cairo_stroke(context_.get());
}

void Canvas::pill(double x, double y, double width, double height, Colour colour)
{
  const double radius = height / 2;
  use(colour);
  cairo_new_sub_path(context_.get());
  cairo_arc(context_.get(), x + radius, y + radius, radius, pi / 2, 3 * pi / 2);
  cairo_arc(context_.get(), x + width - radius, y + radius, radius, -pi / 2, pi / 2);
  cairo_close_path(context_.get());
  cairo_fill(context_.get());
}

void Canvas::line(double from_x, double from_y, double to_x, double to_y, double width, Colour colour)
{
  use(colour);
  cairo_set_line_width(context_.get(), width);
  cairo_move_to(context_.get(), from_x, from_y);
  cairo_line_to(context_.get(), to_x, to_y);
  cairo_stroke(context_.get());
}

void Canvas::dashes(double from_x, double from_y, double to_x, double to_y, Colour colour)
{
  const double dashes[] = {6, 5};
  cairo_set_dash(context_.get(), dashes, 2, 0);
  line(from_x, from_y, to_x, to_y, 1.5, colour);
  cairo_set_dash(context_.get(), nullptr, 0, 0);
}

void Canvas::area(const std::vector<std::pair<double, double>>& points, double base, Colour colour, double opacity)
{
  cairo_new_path(context_.get());
  for (const auto& [x, y] : points)
    cairo_line_to(context_.get(), x, y);
  cairo_path_t* const edge = cairo_copy_path(context_.get());
  cairo_line_to(context_.get(), points.back().first, base);
  cairo_line_to(context_.get(), points.front().first, base);
  cairo_close_path(context_.get());
  use(colour, opacity);
  cairo_fill(context_.get());
  cairo_append_path(context_.get(), edge);
  cairo_path_destroy(edge);
  use(colour);
  cairo_set_line_width(context_.get(), 2);
  cairo_stroke(context_.get());
}

void Canvas::text(double x, double y, const std::string& line, const Font& font, Anchor anchor)
{
  const double width = anchor == Anchor::Left ? 0 : widthOf(line, font);
  use(font);
  cairo_move_to(context_.get(), anchor == Anchor::Middle ? x - width / 2 : x - width, y);
  cairo_show_text(context_.get(), line.c_str());
}

double Canvas::widthOf(const std::string& line, const Font& font)
{
  use(font);
  cairo_text_extents_t extents;
  cairo_text_extents(context_.get(), line.c_str(), &extents);
  return extents.x_advance;
}

std::string Canvas::shortened(const std::string& line, double width, const Font& font)
{
  std::string head = line.substr(0, line.size() / 2);
  std::string tail = line.substr(head.size());
  const auto dropFirst = [&tail] {
    do
      tail.erase(0, 1);
    while (!tail.empty() && !startsCharacter(tail.front()));
  };
  while (!tail.empty() && !startsCharacter(tail.front())) {
    head += tail.front();
    tail.erase(0, 1);
  }
  std::string result = line;
  while (widthOf(result, font) > width && !(head.empty() && tail.empty())) {
    if (head.size() > tail.size()) {
      while (!startsCharacter(head.back()))
        head.pop_back();
      head.pop_back();
    }
    else {
      dropFirst();
    }
    result = head;
    result += "…";
    result += tail;
  }
  return result;
}

std::vector<std::string> Canvas::wrapped(const std::string& text, double width, const Font& font)
{
  std::vector<std::string> lines;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    std::string longer = lines.empty() ? "" : lines.back() + ' ';
    longer += word;
    if (lines.empty() || widthOf(longer, font) > width)
      lines.push_back(shortened(word, width, font));
    else
      lines.back() = longer;
  }
  return lines;
}

void Canvas::paint(int x, int y, int width, int height, const std::function<Paint(int column, int row)>& paint_of)
{
  cairo_surface_flush(surface_.get());
  auto* const data = cairo_image_surface_get_data(surface_.get());
  const std::ptrdiff_t stride = cairo_image_surface_get_stride(surface_.get());
  for (int row = 0; row < height; ++row) {
    auto* const pixels = reinterpret_cast<Colour*>(data + (y + row) * stride) + x;
    for (int column = 0; column < width; ++column)
      if (const Paint paint = paint_of(column, row); paint.opacity > 0)
        pixels[column] = between(pixels[column], paint.colour, paint.opacity);
  }
  cairo_surface_mark_dirty(surface_.get());
}

std::string Canvas::png() const
{
  require(cairo_status(context_.get()));
  std::string file;
  const auto append = [](void* to, const unsigned char* data, unsigned int size) {
    static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(data), size);
    return CAIRO_STATUS_SUCCESS;
  };
  require(cairo_surface_write_to_png_stream(surface_.get(), append, &file));
  return file;
}

} // namespace pcl_gpu_icp::view
