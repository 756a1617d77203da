// The rule for each statement of an OBJ file, by its first word. A word without a rule is told.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace equaltime {

enum class ObjUse {
  vertex,
  uv,
  normal,
  face,
  material,
  libraries,
  smoothing,
  named,   // silent; all after the word is a name
  silent,  // has no meaning for the picture
  told,
};

struct ObjWord {
  std::string_view word;
  ObjUse use;
  std::string_view why;  // of silence; or what is told of the statement
};

inline constexpr std::string_view kUnknownWord = "is no statement of OBJ that is read";

inline constexpr std::array kObjWords = {
    ObjWord{"v", ObjUse::vertex, ""},
    ObjWord{"f", ObjUse::face, ""},
    ObjWord{"vt", ObjUse::uv, ""},
    ObjWord{"vn", ObjUse::normal, ""},
    ObjWord{"fo", ObjUse::face, ""},  // as version 2 of the format wrote it
    ObjWord{"usemtl", ObjUse::material, ""},
    ObjWord{"mtllib", ObjUse::libraries, ""},
    ObjWord{"s", ObjUse::smoothing, "is not used: faces without vn are smooth wherever they share vertices"},
    ObjWord{"o", ObjUse::named, "a picture has no names"},
    ObjWord{"g", ObjUse::named, "a picture has no names"},
    ObjWord{"lod", ObjUse::silent, "chooses among details that the file does not have"},
    ObjWord{"vp", ObjUse::silent, "is a point of curves and surfaces, which are told"},
    ObjWord{"cstype", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"deg", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"bmat", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"step", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"parm", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"trim", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"hole", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"scrv", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"sp", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"con", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"end", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"mg", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"ctech", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"stech", ObjUse::silent, "belongs to curves and surfaces"},
    ObjWord{"curv", ObjUse::told, "is not rendered: curves and surfaces are not read"},
    ObjWord{"curv2", ObjUse::told, "is not rendered: curves and surfaces are not read"},
    ObjWord{"surf", ObjUse::told, "is not rendered: curves and surfaces are not read"},
    ObjWord{"l", ObjUse::told, "is not rendered: a line has no surface"},
    ObjWord{"p", ObjUse::told, "is not rendered: a point has no surface"},
    ObjWord{"call", ObjUse::told, "is not followed: other files are not read"},
    ObjWord{"usemap", ObjUse::told, "is not used: images come from materials"},
    ObjWord{"maplib", ObjUse::told, "is not used: images come from materials"},
};

/// The rule for a word, in whatever case; one that tells of it if there is none.
[[nodiscard]] inline ObjWord obj_word(std::string_view word) noexcept {
  const auto resolve_constant_blend = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  const auto same = [&](const ObjWord& rule) {
    return std::equal(word.begin(), word.end(), rule.word.begin(), rule.word.end(),
                      [&](char a, char b) { return resolve_constant_blend(a) == b; });
  };
  const auto* const found = std::find_if(kObjWords.begin(), kObjWords.end(), same);
  return found != kObjWords.end() ? *found : ObjWord{word, ObjUse::told, kUnknownWord};
}

/// The rule for a line that begins with v, f, vt or vn and a blank, as nearly all do; null for others.
[[nodiscard]] inline const ObjWord* frequent_obj_word(std::string_view line) noexcept {
  if (line.size() < 3) return nullptr;
  if (line[1] == ' ') return line[0] == 'v' ? &kObjWords[0] : line[0] == 'f' ? &kObjWords[1] : nullptr;
  if (line[0] != 'v' || line[2] != ' ') return nullptr;
  return line[1] == 't' ? &kObjWords[2] : line[1] == 'n' ? &kObjWords[3] : nullptr;
}

/// Whether the rest of the line after a word is a name, which no backslash continues.
[[nodiscard]] inline bool takes_name(ObjUse use) noexcept {
  return use == ObjUse::material || use == ObjUse::libraries || use == ObjUse::named;
}

}  // namespace equaltime
