// SPDX-License-Identifier: Apache-2.0
// What the generated pages of the documentation have in common.
#ifndef TRACKSERVO_MARKDOWN_HPP
#define TRACKSERVO_MARKDOWN_HPP

#include <cctype>
#include <string>
#include <vector>

namespace trackservo {

// Returns the anchor that a heading gets: lower case, blanks as hyphens, other signs left out.
inline std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char letter : heading) {
    if (letter == ' ' || letter == '-') {
      anchor += '-';
    } else if (std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '_') {
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    }
  }
  return anchor;
}

// Returns "Contents: [..](#..) · ..." in lines of at most 120 characters. `mark` surrounds each heading: "`" for code.
inline std::string contents_of(const std::vector<std::string>& headings, const std::string& mark = "") {
  constexpr std::size_t kWidth = 120;
  constexpr const char *kBetween = " ·";  // one character, two bytes
  std::string page;
  std::string line = "Contents:";
  for (const std::string& heading : headings) {
    const bool last = &heading == &headings.back();
    std::string link = " [";
    link.append(mark).append(heading).append(mark).append("](#").append(anchor_of(heading)).append(")");
    link.append(last ? "" : kBetween);
    if (line.size() + link.size() > kWidth) {
      page += line + "\n";
      line = link.substr(1);
    } else {
      line += link;
    }
  }
  return page + line + "\n";
}

}  // namespace trackservo

#endif
