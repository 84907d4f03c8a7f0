# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# The corpus of a fuzzer is one file in the repository, tests/fuzz/corpus/TARGET.tar.gz: a tar archive of its inputs.
# The same inputs always give the same bytes: entries are sorted by name and carry no time and no owner.

# pack_corpus FOLDER ARCHIVE: writes ARCHIVE, of all files in FOLDER.
pack_corpus() {
  tar --create --format=ustar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner --mode=0644 \
    --directory "$1" --files-from <(cd "$1" && find . -type f -printf '%P\n' | LC_ALL=C sort) | gzip -n -9 >"$2.new"
  mv "$2.new" "$2"
}

# unpack_corpus ARCHIVE FOLDER: replaces FOLDER by what is in ARCHIVE.
unpack_corpus() {
  rm -rf "$2"
  mkdir -p "$2"
  tar --extract --gzip --file "$1" --directory "$2"
}

# corpus_size FOLDER: the number of its inputs.
corpus_size() {
  find "$1" -type f | wc -l
}
