// Arithmetic on films: moments, the statistics of pixels, and sums over neighbourhoods.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <optional>

#include "equaltime/analysis/error_parts.h"
#include "equaltime/bindings/bindings.h"
#include "equaltime/film/second_nets.h"
#include "equaltime/film/statistics.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

using Moments = py::array_t<PixelMoments, py::array::c_style>;
using Doubles = py::array_t<double, py::array::c_style>;
using Counts = py::array_t<std::int64_t, py::array::c_style>;

Moments merge_moments(const Moments& a, const Moments& b) {
  if (a.ndim() != b.ndim() || !std::equal(a.shape(), a.shape() + a.ndim(), b.shape()))
    throw std::invalid_argument("moments of different shapes");
  Moments joined(std::vector<py::ssize_t>(a.shape(), a.shape() + a.ndim()));
  std::transform(a.data(), a.data() + a.size(), b.data(), joined.mutable_data(), PixelMoments::merge);
  return joined;
}

py::tuple join(const Moments& moments) {
  if (moments.ndim() != 3) throw std::invalid_argument("moments are (R, H, W)");
  const py::ssize_t height = moments.shape(1), width = moments.shape(2);
  Doubles mean({height, width, py::ssize_t{3}}), variance({height, width, py::ssize_t{3}});
  Counts samples({height, width});
  const PixelMoments* from = moments.data();
  double *mean_to = mean.mutable_data(), *variance_to = variance.mutable_data();
  std::int64_t* samples_to = samples.mutable_data();
  const auto replicates = static_cast<std::size_t>(moments.shape(0)), pixels = static_cast<std::size_t>(height * width);
  {
    const py::gil_scoped_release release;
    for (std::size_t i = 0; i < pixels; ++i) {
      const JoinedPixel pixel = join_replicates(from + i, replicates, pixels);
      std::copy_n(pixel.mean, 3, mean_to + 3 * i);
      std::copy_n(pixel.variance, 3, variance_to + 3 * i);
      samples_to[i] = static_cast<std::int64_t>(pixel.samples);
    }
  }
  return py::make_tuple(mean, variance, samples);
}

Doubles deviations(const Moments& moments) {
  if (moments.ndim() != 3) throw std::invalid_argument("moments are (R, H, W)");
  Doubles found({moments.shape(1), moments.shape(2), py::ssize_t{3}});
  const PixelMoments* from = moments.data();
  double* to = found.mutable_data();
  const auto replicates = static_cast<std::size_t>(moments.shape(0));
  const auto pixels = static_cast<std::size_t>(moments.shape(1) * moments.shape(2));
  const py::gil_scoped_release release;
  for (std::size_t i = 0; i < pixels; ++i) {
    double deviation[3];
    sample_deviation(from + i, replicates, pixels, deviation);
    std::copy_n(deviation, 3, to + 3 * i);
  }
  return found;
}

/// What a function makes of the neighbourhoods of an image.
template <auto Function>
Doubles of_neighbourhoods(const Doubles& image) {
  if (image.ndim() != 3) throw std::invalid_argument("an image is (H, W, C)");
  const auto size = [&](int axis) { return static_cast<std::size_t>(image.shape(axis)); };
  const std::span<const double> values(image.data(), static_cast<std::size_t>(image.size()));
  Doubles found({image.shape(0), image.shape(1), image.shape(2)});
  const std::span<double> to(found.mutable_data(), values.size());
  const py::gil_scoped_release release;
  Function(values, size(0), size(1), size(2), to);
  return found;
}

PixelEstimates estimates(const Doubles& mean, const Doubles& variance, const Counts& samples) {
  if (samples.ndim() != 2 || mean.size() != 3 * samples.size() || variance.size() != mean.size())
    throw std::invalid_argument("samples are (H, W), mean and variance (H, W, 3)");
  return {mean.data(), variance.data(), samples.data(), static_cast<std::size_t>(samples.shape(0)),
          static_cast<std::size_t>(samples.shape(1))};
}

py::tuple parts_of_error(const Doubles& mean, const Doubles& variance, const Counts& samples, double floor,
                         const std::optional<Doubles>& least) {
  PixelEstimates pixels = estimates(mean, variance, samples);
  if (least && least->size() != mean.size()) throw std::invalid_argument("the least light is (H, W, 3)");
  if (least) pixels.least = least->data();
  Doubles found({py::ssize_t{3}, samples.shape(0), samples.shape(1)});
  const auto count = static_cast<std::size_t>(samples.size());
  const std::span<double> to(found.mutable_data(), 3 * count);
  ErrorSums sums;
  {
    const py::gil_scoped_release release;
    sums = error_parts(pixels, floor, {to.first(count), to.subspan(count, count), to.last(count)});
  }
  const py::dict named("slopes"_a = sums.slopes, "locals_squared"_a = sums.locals_squared, "crossed"_a = sums.crossed,
                       "means_squared"_a = sums.means_squared);
  return py::make_tuple(found, named);
}

py::array_t<float> errors_of_pixels(const Doubles& mean, const Doubles& variance, const Counts& samples) {
  const PixelEstimates pixels = estimates(mean, variance, samples);
  py::array_t<float> errors({samples.shape(0), samples.shape(1), py::ssize_t{3}});
  const std::span<float> to(errors.mutable_data(), static_cast<std::size_t>(errors.size()));
  const py::gil_scoped_release release;
  standard_errors(pixels, to);
  return errors;
}

py::array_t<std::int64_t> pixels_of_second_nets(std::uint64_t seed, std::uint32_t width, std::uint32_t height,
                                                std::uint32_t second_net) {
  const SecondNets nets(seed, width, height, second_net);
  return py::array_t<std::int64_t>({nets.film().height(), nets.film().width()}, nets.pixels().data());
}

}  // namespace

void bind_film(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(PixelMoments, mean, count, deviation);
  m.def("merge_moments", &merge_moments, "a"_a, "b"_a,
        "Moments of the union of two disjoint sets of samples, pixel by pixel: (R, H, W) each.");
  m.def(
      "join_replicates", &join, "moments"_a,
      "(R, H, W) moments as the mean of all samples (H, W, 3), the estimated variance of that mean, and their number.");
  m.def("sample_deviations", &deviations, "moments"_a,
        "(R, H, W) moments as the standard deviation of one sample, (H, W, 3).");
  m.attr("MOST_PIXELS_A_SECOND_NET") = SecondNets::kMostPixels;
  m.def("second_net_pixels", &pixels_of_second_nets, "seed"_a, "width"_a, "height"_a, "second_net"_a,
        "(h, w): the pixel, y * width + x, that each second net of a render is of; -1: of none. ValueError unless "
        "`second_net` is a power of two up to MOST_PIXELS_A_SECOND_NET.");
  m.def("box_sum", &of_neighbourhoods<box_sum>, "image"_a, "Sums over 7x7 neighbourhoods of (H, W, C), zeros outside.");
  m.def("nearest_mean", &of_neighbourhoods<nearest_mean>, "image"_a,
        "Means over the pixels around each of (H, W, C) without itself (by not a bit), by a Gaussian of 0.8 pixels "
        "within 5x5; 0 for a single pixel.");
  m.def("others_sum", &of_neighbourhoods<others_sum>, "image"_a,
        "Sums over 7x7 neighbourhoods of (H, W, C) without the pixel itself (by not a bit), zeros outside.");
  m.def("error_contributions", &parts_of_error, "mean"_a, "variance"_a, "samples"_a, "floor"_a, "least"_a = py::none(),
        "Each pixel's part of error² by three references (value, lenient, cautious), (3, H, W), and sums over all "
        "pixels (ErrorContributions and ErrorSums of cpp/equaltime/analysis/error_parts.h).");
  m.def("standard_errors", &errors_of_pixels, "mean"_a, "variance"_a, "samples"_a,
        "(H, W, 3) standard errors, their variances pooled over 7x7 neighbourhoods; inf where unknown.");
}

}  // namespace equaltime
