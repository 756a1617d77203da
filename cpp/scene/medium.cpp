#include "scene/medium.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "scene/interaction.h"
#include "scene/normalization.h"

namespace equaltime {

namespace {

/// exp(-sigma·t); 1 where nothing is in the way, however far that is.
double transmitted(double sigma, double t) noexcept { return sigma > 0 ? std::exp(-sigma * t) : 1.0; }

/// Where there is no end, nothing is looked for beyond: 2^30 times the scene, from where no float32 tells its light
/// from none.
constexpr double kFarthest = 0x1p40;

/// Mean free path over the extent of the scene down to which media are rendered: below, float32 leaves the edges of
/// shapes and the points of lights many mean free paths from where they are.
constexpr double kShortestFreePath = 1e-7;

struct Colors {
  explicit Colors(const Spectrum& s) noexcept
      : of{static_cast<double>(s.r), static_cast<double>(s.g), static_cast<double>(s.b)} {}
  double of[3];
};

/// The same for each colour. Most media are grey, so that equal exponentials are computed once.
void transmitted(const Colors& sigma, double t, double (&left)[3]) noexcept {
  left[0] = transmitted(sigma.of[0], t);
  left[1] = sigma.of[1] == sigma.of[0] ? left[0] : transmitted(sigma.of[1], t);
  left[2] = sigma.of[2] == sigma.of[1] ? left[1] : transmitted(sigma.of[2], t);
}

Spectrum quotients(const double (&numerators)[3], double denominator) noexcept {
  return {static_cast<float>(numerators[0] / denominator), static_cast<float>(numerators[1] / denominator),
          static_cast<float>(numerators[2] / denominator)};
}

/// The lobes that there are, each once; `fail` throws for numbers that make no sense.
template <class Fail>
std::vector<PhaseLobeDescription> distinct(const MediumDescription& d, const Fail& fail) {
  if (d.lobes.empty()) return {{1, d.g, false}};
  std::vector<PhaseLobeDescription> kept;
  for (const PhaseLobeDescription& lobe : d.lobes) {
    if (!(lobe.weight >= 0 && lobe.weight <= 1)) fail("the weight of a phase function lies in [0, 1]");
    if (!(lobe.g > -1 && lobe.g < 1)) fail("g lies between -1 and 1");
    if (!(lobe.weight > 0)) continue;
    const auto same = std::ranges::find_if(kept, [&](const PhaseLobeDescription& other) {
      return lobe.rayleigh == other.rayleigh && (lobe.rayleigh || lobe.g == other.g);
    });
    if (same == kept.end())
      kept.push_back(lobe);
    else
      same->weight += lobe.weight;
  }
  if (kept.empty()) fail("one of the phase functions needs a weight above 0");
  if (kept.size() > BlendedPhase::kMostLobes) fail("a blend has at most 8 phase functions");
  return kept;
}

Bsdf make_phase(const std::vector<PhaseLobeDescription>& lobes, const Spectrum& albedo) {
  if (lobes.size() == 1 && !lobes[0].rayleigh) return Phase{static_cast<float>(lobes[0].g), albedo};
  double total = 0;
  for (const PhaseLobeDescription& lobe : lobes) total += lobe.weight;
  BlendedPhase blend;
  blend.single_albedo = albedo;
  for (const PhaseLobeDescription& lobe : lobes)
    blend.lobes[blend.count++] = {static_cast<float>(lobe.weight / total), static_cast<float>(lobe.g), lobe.rayleigh};
  return blend;
}

}  // namespace

Spectrum Medium::transmittance(double t) const noexcept {
  const Colors sigma(sigma_t);
  double left[3];
  transmitted(sigma, t, left);
  return quotients(left, 1);
}

Flight Medium::sample(const Spectrum& beta, double distance, Point2d u) const noexcept {
  if (sigma_s.is_black()) return {distance, false, transmittance(distance)};
  const Colors sigma(sigma_t), scattering(sigma_s), weight(beta);
  const double sum = weight.of[0] + weight.of[1] + weight.of[2];
  const double place = u.y * sum;
  int picked = 2;
  if (place < weight.of[0])
    picked = 0;
  else if (place < weight.of[0] + weight.of[1] || !(weight.of[2] > 0))
    picked = weight.of[1] > 0 ? 1 : 0;
  const double extinction = sigma.of[picked];
  const double drawn = extinction > 0 ? -std::log1p(-u.x) / extinction : std::numeric_limits<double>::infinity();
  const bool collides = drawn < distance;
  const double t = collides ? drawn : distance;
  if (collides && t > kFarthest) return {0, true, {}};
  double left[3], values[3], density = 0;
  transmitted(sigma, t, left);
  for (int c = 0; c < 3; ++c) {
    density += weight.of[c] / sum * (collides ? sigma.of[c] * left[c] : left[c]);
    values[c] = collides ? scattering.of[c] * left[c] : left[c];
  }
  return {t, collides, quotients(values, density)};
}

std::uint32_t Media::at(const std::optional<std::uint32_t>& described) const {
  if (!described) return kNone;
  if (*described >= index.size()) throw std::invalid_argument("no medium " + std::to_string(*described));
  return index[*described];
}

namespace {

/// Says what is wrong with a medium that is denser than the scene can be rendered with; empty if it is not.
std::string too_dense(const Spectrum& sigma_t, const Normalization& normalization) {
  const Bounds& bounds = normalization.bounds();
  const double extent = bounds.empty() ? 0 : max_component(bounds.extent());
  const double share = 1 / (static_cast<double>(sigma_t.max_component()) * extent);
  if (share >= kShortestFreePath) return {};
  std::ostringstream message;
  message << std::setprecision(3) << "its mean free path is " << share << " of the scene's extent, and the shortest is "
          << kShortestFreePath << "; lower sigma_t or scale, or make the shape opaque";
  return message.str();
}

}  // namespace

Media make_media(const std::vector<MediumDescription>& descriptions, const Normalization& normalization) {
  Media media;
  const double per_length = normalization.world_length(1);
  for (const MediumDescription& d : descriptions) {
    const auto fail = [&](const char* what) {
      throw std::invalid_argument("medium " + std::to_string(media.index.size()) + ": " + what);
    };
    const auto in = [](const Vec3d& v, double most) {
      return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x <= most && v.y <= most && v.z <= most;
    };
    if (!in(d.sigma_t, std::numeric_limits<double>::max())) fail("extinction is finite and not negative");
    if (!in(d.albedo, 1)) fail("an albedo lies in [0, 1]");
    const Spectrum sigma_t = spectrum(d.sigma_t * per_length), albedo = spectrum(d.albedo);
    if (!(d.g > -1 && d.g < 1)) fail("g lies between -1 and 1");
    if (!sigma_t.is_finite()) fail("extinction is too large for the size of the scene");
    if (const std::string dense = too_dense(sigma_t, normalization); !dense.empty()) fail(dense.c_str());
    const Bsdf phase = make_phase(distinct(d, fail), albedo);
    media.index.push_back(sigma_t.is_black() ? kNone : static_cast<std::uint32_t>(media.dense.size()));
    if (!sigma_t.is_black()) media.dense.push_back({sigma_t, sigma_t * albedo, phase});
  }
  return media;
}

}  // namespace equaltime
