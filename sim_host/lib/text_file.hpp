// SPDX-License-Identifier: Apache-2.0
// Text files of users, as editors and spreadsheets on Windows, macOS and Linux write them.
#ifndef TRACKSERVO_TEXT_FILE_HPP
#define TRACKSERVO_TEXT_FILE_HPP

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace trackservo {

// Why a file is no text, with the remedy, and in which line, from 1 on. The caller knows the file's name.
class TextFileError : public std::runtime_error {
 public:
  TextFileError(int line, const std::string& reason) : std::runtime_error(reason), line_(line) {}
  int line() const { return line_; }

 private:
  int line_;
};

// Returns a file or pipe in UTF-8, its lines ended by LF. Taken are UTF-8 with or without its mark, and UTF-16 and
// UTF-32 with theirs, also twice; what is no UTF-8 is Latin-1, which comments may be in. Lines may end with CR LF or
// CR. NUL and the end-of-file mark of DOS are cut off at the end. Throws TextFileError for what cannot be read, is
// larger than `most_bytes`, or has another NUL in it.
std::string read_text(const std::filesystem::path& path, std::size_t most_bytes = 200'000'000);

}  // namespace trackservo

#endif
