#include "equaltime/build/build_media.h"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "equaltime/base/index.h"

namespace equaltime {

namespace {

/// Mean free path over the extent of the scene down to which media are rendered: below, float32 leaves the edges of
/// shapes and the points of lights many mean free paths from where they are.
constexpr double kShortestFreePath = 1e-7;

/// The end of an error: the number that was found.
std::string found(const Vec3d& value) {
  std::ostringstream text;
  text << "; found (" << value.x << ", " << value.y << ", " << value.z << ")";
  return text.str();
}

/// The lobes that there are, each once; `fail` throws if that makes no phase function.
template <class Fail>
std::vector<PhaseLobeDescription> distinct(const MediumDescription& d, const Fail& fail) {
  std::vector<PhaseLobeDescription> kept;
  for (PhaseLobeDescription lobe : d.phase) {
    if (!(lobe.weight > 0)) continue;
    if (lobe.law == PhaseDescription(HenyeyGreensteinDescription{0})) lobe.law = IsotropicDescription{};
    const auto same = std::ranges::find(kept, lobe.law, &PhaseLobeDescription::law);
    if (same == kept.end())
      kept.push_back(lobe);
    else
      same->weight += lobe.weight;
  }
  if (kept.empty() && !d.phase.empty()) fail("one of the phase functions needs a weight above 0");
  if (kept.size() > PhaseBlend::kMostLobes) fail("a blend of more than 8 phase functions");
  return kept;
}

/// A phase function that holds the model of a law.
template <class Variant>
Variant make_law(const PhaseDescription& law) {
  Variant made;
  PhaseLobes::for_each([&]<class Model>(std::type_identity<Model>) {
    if (const auto* d = std::get_if<typename Model::Description>(&law)) made = Model(*d);
  });
  return made;
}

PhaseFunction make_phase(const std::vector<PhaseLobeDescription>& lobes) {
  if (lobes.empty()) return IsotropicPhase();
  if (lobes.size() == 1) return make_law<PhaseFunction>(lobes[0].law);
  double total = 0;
  for (const PhaseLobeDescription& lobe : lobes) total += lobe.weight;
  PhaseBlend blend;
  for (const PhaseLobeDescription& lobe : lobes)
    blend.lobes[blend.count++] = {static_cast<float>(lobe.weight / total), make_law<PhaseLobes::Variant>(lobe.law)};
  return blend;
}

/// Says what is wrong with a medium that is denser than the scene can be rendered with; empty if it is not.
std::string too_dense(const Spectrum& sigma_t, const Normalization& normalization) {
  const Bounds& bounds = normalization.bounds();
  const double extent = bounds.empty() ? 0 : max_component(bounds.extent());
  const double free_path = 1 / (static_cast<double>(sigma_t.max_component()) * extent);
  if (free_path >= kShortestFreePath) return {};
  std::ostringstream message;
  message << std::setprecision(3) << "its mean free path is " << free_path
          << " of the scene's extent, and the shortest is " << kShortestFreePath
          << "; lower sigma_t or scale, or make the shape opaque";
  return message.str();
}

}  // namespace

std::uint32_t Media::at(const std::optional<std::uint32_t>& described) const {
  if (!described) return kNone;
  if (*described >= index.size()) throw std::invalid_argument("no medium " + std::to_string(*described));
  return index[*described];
}

Media make_media(const std::vector<MediumDescription>& descriptions, const Normalization& normalization) {
  Media media;
  const double per_length = normalization.world_length(1);
  for (const MediumDescription& d : descriptions) {
    const auto fail = [&](const std::string& problem) {
      throw std::invalid_argument("medium " + std::to_string(media.index.size()) + ": " + problem);
    };
    const auto in = [](const Vec3d& v, double most) {
      return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x <= most && v.y <= most && v.z <= most;
    };
    if (!in(d.sigma_t, std::numeric_limits<double>::max()))
      fail("extinction is finite and not negative" + found(d.sigma_t));
    if (!in(d.albedo, 1)) fail("an albedo lies in [0, 1]" + found(d.albedo));
    const Spectrum sigma_t = spectrum(d.sigma_t * per_length), albedo = spectrum(d.albedo);
    if (!sigma_t.is_finite()) fail("extinction is too large for the size of the scene");
    if (const std::string dense = too_dense(sigma_t, normalization); !dense.empty()) fail(dense);
    PhaseFunction phase = make_phase(distinct(d, fail));
    std::visit([&](auto& model) { model.single_albedo = albedo; }, phase);
    media.index.push_back(sigma_t.is_black() ? kNone : static_cast<std::uint32_t>(media.dense.size()));
    if (!sigma_t.is_black()) media.dense.push_back({sigma_t, sigma_t * albedo}), media.phases.push_back(phase);
  }
  return media;
}

}  // namespace equaltime
