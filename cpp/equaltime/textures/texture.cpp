#include "equaltime/textures/texture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

template <class T>
T load(const std::byte* at) noexcept {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return value;
}

/// A finite half-precision number; the factor puts its exponent right, of subnormal ones too.
float from_half(std::uint16_t h) noexcept {
  const std::uint32_t sign = (h & 0x8000U) << 16, magnitude = (h & 0x7fffU) << 13;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(std::bit_cast<float>(magnitude) * 0x1p112F) | sign);
}
bool is_finite_half(std::uint16_t h) noexcept { return (h & 0x7c00U) != 0x7c00U; }

float from_srgb(double encoded) noexcept {
  return static_cast<float>(encoded <= 0.04045 ? encoded / 12.92 : elementary::pow((encoded + 0.055) / 1.055, 2.4));
}

std::size_t bytes_of(TexelFormat format) noexcept {
  return format == TexelFormat::u8 ? 1 : format == TexelFormat::half ? 2 : 4;
}

/// The coordinate taken into [0, 1]; anything that is no number is 0.
float fold(float x, TextureWrap wrap) noexcept {
  if (wrap == TextureWrap::repeat) x -= std::floor(x);
  if (wrap == TextureWrap::mirror) {
    x -= 2 * std::floor(0.5F * x);
    x = std::min(x, 2 - x);
  }
  return std::min(std::max(0.0F, x), 1.0F);
}

/// Which way a resolve_constant_blend coordinate runs.
float direction(float x, TextureWrap wrap) noexcept {
  return wrap == TextureWrap::mirror && x - 2 * std::floor(0.5F * x) > 1 ? -1.0F : 1.0F;
}

/// Two neighbouring texels along an axis, and how far between their centres.
struct Neighbours {
  std::size_t low, high;
  float rest;
};
Neighbours neighbours(float x, std::uint32_t n, TextureWrap wrap) noexcept {
  const float place = fold(x, wrap) * static_cast<float>(n) + 0.5F;  // from half a texel before the first
  const auto next = std::min(static_cast<std::uint32_t>(place), n);
  const bool around = wrap == TextureWrap::repeat;
  const std::uint32_t before_first = around ? n - 1 : 0, after_last = around ? 0 : n - 1;
  return {next == 0 ? before_first : next - 1, next == n ? after_last : next, place - static_cast<float>(next)};
}

std::size_t nearest(float x, std::uint32_t n, TextureWrap wrap) noexcept {
  return std::min(static_cast<std::uint32_t>(fold(x, wrap) * static_cast<float>(n)), n - 1);
}

/// Where scale·x + shift is a whole number and a part, for x from 0 to 1, with both ends.
std::vector<double> knots(double scale, double shift, double part) {
  const double first = std::min(shift, shift + scale), last = std::max(shift, shift + scale);
  std::vector<double> places{0};
  for (double k = std::ceil(first - part); k + part <= last; ++k) {
    const double place = (k + part - shift) / scale;
    if (place > 0 && place < 1) places.push_back(place);
  }
  if (scale < 0) std::reverse(places.begin() + 1, places.end());
  places.push_back(1);
  return places;
}

/// Texels are counted one by one, which needs whole numbers that differ.
constexpr double kFarthestKnot = 0x1p40;

}  // namespace

UvMap::UvMap(const UvTransform& t) noexcept {
  for (std::size_t i = 0; i < t.size(); ++i) m_[i] = static_cast<float>(t[i]);
}

TextureGrid UvMap::grid(double columns, double rows, double part, std::size_t most) const {
  const double across = static_cast<double>(m_[0]) * columns, down = static_cast<double>(m_[4]) * rows;
  const double right = static_cast<double>(m_[2]) * columns, below = static_cast<double>(m_[5]) * rows;
  const auto limit = static_cast<double>(most);
  if (m_[1] != 0 || m_[3] != 0 || !(std::abs(across) < limit && std::abs(down) < limit)) return {};
  if (!(std::abs(right) < kFarthestKnot && std::abs(below) < kFarthestKnot)) return {};
  return {knots(across, right, part), knots(down, below, part)};
}

std::array<double, 6> UvMap::times(double columns, double rows, double part) const noexcept {
  std::array<double, 6> m;
  for (std::size_t i = 0; i < m.size(); ++i) m[i] = static_cast<double>(m_[i]) * (i < 3 ? columns : rows);
  m[2] -= part, m[5] -= part;
  return m;
}

Bitmap::Bitmap(BitmapDescription d)
    : to_uv_(d.to_uv),
      width_(d.width),
      height_(d.height),
      channels_(d.channels),
      format_(d.format),
      filter_(d.filter),
      wrap_(d.wrap),
      texels_(std::move(d.texels)) {
  if (channels_ != 1 && channels_ != 3) throw std::invalid_argument("a bitmap has 1 or 3 channels");
  if (count() == 0 || texels_.size() != count() * channels_ * bytes_of(format_))
    throw std::invalid_argument("a bitmap has as many texels as its size says, and at least one");
  for (std::size_t i = 0; i < decoded_.size(); ++i) {
    const double value = static_cast<double>(i) / 255;
    decoded_[i] = d.srgb ? from_srgb(value) : static_cast<float>(value);
  }
  for (std::size_t i = 0; i < count() * channels_; ++i) {
    const bool finite = format_ == TexelFormat::u8     ? true
                        : format_ == TexelFormat::half ? is_finite_half(load<std::uint16_t>(&texels_[2 * i]))
                                                       : std::isfinite(load<float>(&texels_[4 * i]));
    if (!finite) throw std::invalid_argument("texel " + std::to_string(i / channels_) + " of a bitmap is not finite");
  }
}

template <class Decode>
Spectrum Bitmap::look_up(Point2f place, Decode decode) const noexcept {
  if (filter_ == TextureFilter::nearest)
    return decode(nearest(place.y, height_, wrap_) * width_ + nearest(place.x, width_, wrap_));
  const auto [left, right, x] = neighbours(place.x, width_, wrap_);
  const auto [top, bottom, y] = neighbours(place.y, height_, wrap_);
  const std::size_t upper = top * width_, lower = bottom * width_;
  return (decode(upper + left) * (1 - x) + decode(upper + right) * x) * (1 - y) +
         (decode(lower + left) * (1 - x) + decode(lower + right) * x) * y;
}

Spectrum Bitmap::eval(const TextureCoords& at) const noexcept {
  const Point2f place = to_uv_(at.uv);
  const std::byte* first = texels_.data();
  if (format_ == TexelFormat::u8 && channels_ == 3)
    return look_up(place, [&](std::size_t i) noexcept {
      const std::byte* t = first + 3 * i;
      return Spectrum(decoded_[load<std::uint8_t>(t)], decoded_[load<std::uint8_t>(t + 1)],
                      decoded_[load<std::uint8_t>(t + 2)]);
    });
  return look_up(place, [&](std::size_t i) noexcept { return texel(i); });
}

Point2f Bitmap::gradient(const TextureCoords& at) const noexcept {
  if (filter_ == TextureFilter::nearest) return {0, 0};
  const Point2f place = to_uv_(at.uv);
  const auto [left, right, x] = neighbours(place.x, width_, wrap_);
  const auto [top, bottom, y] = neighbours(place.y, height_, wrap_);
  const auto height = [&](std::size_t row, std::size_t column) noexcept {
    return texel(row * width_ + column).luminance();
  };
  const float a = height(top, left), b = height(top, right), c = height(bottom, left), d = height(bottom, right);
  const float along_u = static_cast<float>(width_) * ((b - a) * (1 - y) + (d - c) * y);
  const float along_v = static_cast<float>(height_) * ((c - a) * (1 - x) + (d - b) * x);
  return to_uv_.pull_back({along_u * direction(place.x, wrap_), along_v * direction(place.y, wrap_)});
}

Spectrum Bitmap::texel(std::size_t index) const noexcept {
  const auto channel = [&](std::size_t c) noexcept {
    const std::byte* at = &texels_[(index * channels_ + c) * bytes_of(format_)];
    if (format_ == TexelFormat::u8) return decoded_[load<std::uint8_t>(at)];
    return format_ == TexelFormat::half ? from_half(load<std::uint16_t>(at)) : load<float>(at);
  };
  if (channels_ == 1) return Spectrum(channel(0));
  return {channel(0), channel(1), channel(2)};
}

std::optional<Spectrum> Bitmap::constant() const noexcept {
  const Spectrum color = texel(0);
  for (std::size_t i = 1; i < count(); ++i)
    if (texel(i) != color) return std::nullopt;
  return color;
}

TextureGrid Bitmap::grid(std::size_t most) const {
  const bool steps = filter_ == TextureFilter::nearest;
  TextureGrid grid = to_uv_.grid(width_, height_, steps ? 0 : 0.5, most);
  grid.steps = steps;
  return grid;
}

std::optional<TextureLattice> Bitmap::lattice() const noexcept {
  const bool steps = filter_ == TextureFilter::nearest;
  return TextureLattice{to_uv_.times(width_, height_, steps ? 0 : 0.5), steps};
}

Checkerboard::Checkerboard(const CheckerboardDescription& d) noexcept
    : to_uv_(d.to_uv),
      colors_{spectrum(d.color0), spectrum(d.color1)},
      numbers_{colors_[1].mean(), colors_[0].mean()} {}

std::size_t Checkerboard::square_at(Point2f uv) const noexcept {
  const Point2f place = to_uv_(uv);
  const bool right = place.x - std::floor(place.x) > 0.5F, far = place.y - std::floor(place.y) > 0.5F;
  return right == far ? 0 : 1;
}

std::optional<Spectrum> Checkerboard::constant() const noexcept {
  return colors_[0] == colors_[1] ? std::optional(colors_[0]) : std::nullopt;
}

TextureGrid Checkerboard::grid(std::size_t most) const {
  TextureGrid grid = to_uv_.grid(2, 2, 0, most);
  grid.steps = true;
  return grid;
}

std::optional<TextureLattice> Checkerboard::lattice() const noexcept {
  return TextureLattice{to_uv_.times(2, 2, 0), true};
}

void MeshAttribute::add(std::uint32_t shape, AttributeValues values, std::size_t vertices, std::size_t faces) {
  if (values.width != 1 && values.width != 3) throw std::invalid_argument("an attribute has 1 or 3 numbers");
  if (values.values.size() != (values.per_face ? faces : vertices) * values.width)
    throw std::invalid_argument("an attribute has a value for each vertex, or for each face");
  for (const float value : values.values)
    if (!std::isfinite(value)) throw std::invalid_argument("a value of an attribute is not finite in single precision");
  if (of_shape_.size() <= shape) of_shape_.resize(shape + 1, kNone);
  of_shape_[shape] = static_cast<std::uint32_t>(values_.size());
  values_.push_back(std::move(values));
}

Spectrum MeshAttribute::eval(const TextureCoords& place) const noexcept {
  if (place.shape >= of_shape_.size() || of_shape_[place.shape] == kNone) return {};
  const AttributeValues& own = values_[of_shape_[place.shape]];
  const auto value = [&](std::uint32_t i) noexcept {
    const float* v = &own.values[std::size_t{i} * own.width];
    return own.width == 1 ? Spectrum(v[0]) : Spectrum(v[0], v[1], v[2]);
  };
  if (own.per_face) return value(place.primitive);
  const auto& [a, b, c] = place.corners;
  const auto [u, v] = place.barycentric;
  return value(a) * (1 - u - v) + value(b) * u + value(c) * v;
}

std::size_t MeshAttribute::memory_bytes() const noexcept {
  std::size_t bytes = sizeof(*this) + of_shape_.size() * sizeof(std::uint32_t);
  for (const AttributeValues& own : values_) bytes += sizeof(own) + own.values.size() * sizeof(float);
  return bytes;
}

Texture make_texture(TextureDescription description) {
  if (auto* bitmap = std::get_if<BitmapDescription>(&description)) return Bitmap(std::move(*bitmap));
  if (std::holds_alternative<MeshAttributeDescription>(description)) return MeshAttribute();
  return Checkerboard(std::get<CheckerboardDescription>(description));
}

}  // namespace equaltime
