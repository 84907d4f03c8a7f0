# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# The parts of a release, in the order in which tools/release makes them. Sourced by it after common.sh and uplot.sh; expects
# version. The working folder is the project's.
# shellcheck disable=SC2154

release_folder="$build/release/trackservo-$version"
# Everything is made here, and moved when it is whole.
work="$build/release/work"
out="$work/out"
log="$build/release.log"
releasing="$root/tools/releasing"
machine="linux-$(uname -m)"

check_tree() {
  git rev-parse --verify --quiet HEAD >/dev/null || die "this is no checkout of git: a release is made of a commit."
  [[ -z "$(git status --porcelain)" ]] || die "the tree has changes that are not committed (git status lists them): commit or remove them first."
}

# A tag of this commit is fine: the workflow starts from it.
check_tag() {
  local tagged
  tagged="$(git rev-parse --verify --quiet "refs/tags/v$version^{commit}")" || return 0
  [[ "$tagged" == "$(git rev-parse HEAD)" && "$prepare" == no ]] ||
    die "version $version exists already: the tag v$version is commit ${tagged:0:12}. Choose the next version."
}

check_tools() {
  local tool
  for tool in cmake ninja g++ arm-none-eabi-gcc strip tar gzip sha256sum dpkg-query; do
    need_tool "$tool" release || exit 1
  done
  [[ -x "$release_venv/bin/python" && -x "$venv/bin/python" ]] ||
    die "the Python packages for a release are missing: ./tools/setup release installs them."
  uplot_packed || die "uPlot, the plot library of servoctl's page, is missing: ./tools/setup release installs it."
}

# Of the program of tools/releasing: what it says is the reason.
releasing() {
  local program="$1"
  shift
  "$release_venv/bin/python" -B "$releasing/$program.py" "$@"
}

check_version() {
  local stated
  stated="$(sed -n 's/^  VERSION \([0-9.]*\)$/\1/p' CMakeLists.txt)"
  [[ "$stated" == "$version" ]] || die "the tree has version $stated: tools/release --prepare $version changes it."
  releasing changelog notes CHANGELOG.md "$version" >/dev/null || exit 1
  releasing stored_sets check docs/releases.md "$version" tools/servoctl/servoctl/descriptions/parameters.json || exit 1
}

check_folder() {
  [[ ! -e "$release_folder" ]] || die "${release_folder#"$root/"} exists already: remove it to make version $version again."
}

prepare_version() {
  # All files are as committed, so that a failure can take back everything.
  if ! { releasing prepare "$version" "$(date -u +%F)" && tools/update-docs dictionary; }; then
    git checkout --quiet -- .
    exit 1
  fi
  git --no-pager diff --stat
  echo "Look at these changes and commit them. Then: tools/release $version"
}

# What must not depend on who makes it, and where.
release_environment() {
  unset CFLAGS CXXFLAGS CPPFLAGS LDFLAGS CC CXX CMAKE_C_COMPILER_LAUNCHER CMAKE_CXX_COMPILER_LAUNCHER PYTHONPATH
  SOURCE_DATE_EPOCH="$(git log -1 --format=%ct)"
  export SOURCE_DATE_EPOCH CCACHE_DISABLE=1 LC_ALL=C TZ=UTC PYTHONDONTWRITEBYTECODE=1 PATH="$release_venv/bin:$PATH"
  umask 022
}

begin_release() {
  rm -rf "$work"
  mkdir -p "$out"
  : >"$log"
  trap 'rm -rf "$work"' EXIT
}

# attempt WHAT COMMAND...: its output goes into the log.
attempt() {
  local what="$1"
  shift
  echo "-- $what"
  "$@" >>"$log" 2>&1 </dev/null || die "$what failed (log: ${log#"$root/"})."
}

# packed FOLDER ARCHIVE: the one folder in FOLDER, as ARCHIVE.tar.gz, the same bytes for the same files.
packed() {
  tar --create --sort=name --format=gnu --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner \
    --mode=u+w,go-w,a+rX --directory "$1" "$(ls "$1")" | gzip --no-name --best >"$out/$2.tar.gz"
}

# The presets that make an image for a board, each with the folder of its board.
image_presets() {
  "$release_venv/bin/python" -c '
import json
for preset in json.load(open("CMakePresets.json", encoding="utf-8"))["configurePresets"]:
    variables = preset.get("cacheVariables", {})
    if variables.get("TRACKSERVO_PRODUCT"):
        print(preset["name"], variables["TRACKSERVO_PLATFORM"])'
}

make_images() {
  local preset board image kind
  while read -r preset board; do
    attempt "configuring the image for $board" cmake --preset "$preset" -B "$work/$preset" --no-warn-unused-cli
    attempt "building the image for $board" cmake --build "$work/$preset"
    image="$work/$preset/bin/trackservo"
    for kind in elf hex bin; do
      install -m 644 "$image.$kind" "$out/trackservo-$version-$board.$kind"
    done
    "$venv/bin/python" -B tools/image/budget.py "$image.elf" --stack-usage "$work/$preset" --pointers tools/image/indirect_calls.toml \
      >"$out/trackservo-$version-$board.size.txt"
    make_flash_kit "$board" "$image"
  done < <(image_presets)
}

# The image with what puts it on the board, at the places that the script, fault texts and pages name.
make_flash_kit() {
  local board="$1" image="$2" kit="$work/kit-$1/trackservo-flash-$version-$1"
  mkdir -p "$kit"
  cp --parents tools/image/board tools/image/option_bytes.py tools/lib/common.sh "hal/boards/$board/openocd.cfg" \
    hal/chips/stm32g4/registers/flash.h LICENSE "$kit"
  cp "$image".{elf,hex,bin} "$kit"
  releasing parts licences image "$kit/licenses"
  refuse_paths "$kit"
  packed "$work/kit-$board" "trackservo-flash-$version-$board"
}

make_programs() {
  local host="$work/host" name file
  releasing parts licences units "$work/licenses-units"
  attempt "configuring the programs" cmake --preset host-release -B "$host" -D "TRACKSERVO_UNIT_LICENSES=$work/licenses-units" \
    --no-warn-unused-cli
  attempt "building the programs" cmake --build "$host" --target sim_host identify emulate_board node_descriptions
  for file in parameters.json faults.json version.txt; do
    cmp --silent "$host/share/trackservo/$file" "tools/servoctl/servoctl/descriptions/$file" ||
      die "tools/servoctl/servoctl/descriptions/$file is not what the build prints: tools/update-docs dictionary renews it."
  done
  for name in programs emulator; do
    attempt "packing $name" cmake --install "$host" --strip --component "$name" \
      --prefix "$work/$name/trackservo-$version-$machine"
    releasing parts licences "$name" "$work/$name/trackservo-$version-$machine/share/doc/trackservo/licenses-$name"
    refuse_paths "$work/$name"
    packed "$work/$name" "trackservo-$name-$version-$machine"
  done
  for file in trackservo.eds trackservo.dbc parameters.json faults.json can-objects.md faults.md; do
    install -m 644 "$host/share/trackservo/$file" "$out/$file"
  done
}

make_units() {
  local host="$work/host" name
  attempt "building the units for co-simulation" cmake --build "$host" --target fmus
  for name in plant servo; do
    refuse_paths "$host/sim_host/fmi/trackservo_$name.so"
    install -m 644 "$host/fmu/trackservo_$name.fmu" "$out/trackservo-$name-$version-$machine.fmu"
  done
}

# No file that is released names a folder of this machine.
refuse_paths() {
  local found
  found="$(grep --recursive --files-with-matches --text --fixed-strings "$root" "$@" || true)"
  [[ -z "$found" ]] || die "a path of this machine ($root) is in ${found//$'\n'/, }."
}

make_sources() {
  attempt "packing the sources" git archive --format=tar --prefix="trackservo-$version/" --output="$work/sources.tar" HEAD
  gzip --no-name --best <"$work/sources.tar" >"$out/trackservo-$version-sources.tar.gz"
}

# From a copy of what is committed: a build in the checkout would also pack what an earlier one left.
make_wheels() {
  local stage="$work/wheels" name program
  mkdir -p "$stage"
  git archive HEAD LICENSE tools/servoctl tools/imager tools/identify | tar --extract --warning=no-timestamp --directory "$stage"
  uplot_copy "$uplot_dir" "$stage/tools/servoctl/servoctl/ui/page/uplot"
  program="$work/programs/trackservo-$version-$machine/bin/identify"
  install -m 755 "$program" "$stage/tools/identify/trackservo_identify/identify"
  releasing parts licences identify "$stage/tools/identify/licenses"
  for name in servoctl imager identify; do
    attempt "making the wheel of $name" "$release_venv/bin/python" -m pip wheel --disable-pip-version-check --no-index --no-deps \
      --no-build-isolation --wheel-dir "$stage/made" "$stage/tools/$name"
  done
  attempt "naming the systems of identify's wheel" auditwheel repair --wheel-dir "$out" "$stage"/made/trackservo_identify-*.whl
  cp "$stage"/made/{servoctl,trackservo_imager}-*.whl "$out"
  attempt "checking the wheels' contents" check-wheel-contents "$out"
  attempt "checking the wheels' descriptions" twine check --strict "$out"/*.whl
  make_requirements
}

# The folder of the packages of the project's own Python.
site_packages() { "$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))'; }

# The versions that were tested, with hashes: for servoctl, and for the imager with it.
make_requirements() {
  local site
  site="$(site_packages)"
  releasing python_packages requirements "$site" "$out"/servoctl-*.whl "$out"/trackservo_identify-*.whl >"$out/requirements-servoctl.txt"
  releasing python_packages requirements "$site" "$out"/{servoctl,trackservo_identify,trackservo_imager}-*.whl >"$out/requirements-imager.txt"
}

# For each Python of the Debians that the page names.
make_wheelhouse() {
  local house="$work/wheelhouse/trackservo-wheelhouse-$version-$machine" python platforms=() old
  for old in 2_5 2_12 2_17 2_24 2_26 2_27 2_28 2_31 2_34 2_35; do
    platforms+=(--platform "manylinux_${old}_$(uname -m)")
  done
  platforms+=(--platform "manylinux2014_$(uname -m)" --platform any)
  for python in 3.11 3.13; do
    attempt "downloading the packages for Python $python" "$release_venv/bin/python" -m pip download --disable-pip-version-check \
      --require-hashes --no-deps --only-binary=:all: "${platforms[@]}" --python-version "$python" --implementation cp \
      --find-links "$out" --dest "$house" --requirement "$out/requirements-imager.txt"
  done
  packed "$work/wheelhouse" "trackservo-wheelhouse-$version-$machine"
}

make_pages() {
  local site
  site="$(site_packages)"
  sed "s/@VERSION@/$version/g; s/@MACHINE@/$machine/g" tools/releasing/START.md >"$out/START.md"
  releasing changelog notes CHANGELOG.md "$version" >"$out/CHANGES.md"
  sed -n '/^## Which version keeps which stored set/,/^## /{/^## [^W]/d;p}' docs/releases.md >"$out/STORED-SETS.md"
  releasing sbom "$out" "$version" "$(git rev-parse HEAD)" "$SOURCE_DATE_EPOCH" "$site" >"$out/sbom.cdx.json"
}

finish_release() {
  (cd "$out" && sha256sum -- * >"$work/SHA256SUMS" && mv "$work/SHA256SUMS" .)
  mkdir -p "${release_folder%/*}"
  mv "$out" "$release_folder"
  (cd "$release_folder" && du --apparent-size --human-readable -- *)
}

propose_tag() {
  echo "Made ${release_folder#"$root/"}. To publish it, try it (START.md), then tag the commit and push the tag:"
  echo "  git tag --annotate v$version --message 'trackservo $version' $(git rev-parse --short=12 HEAD)"
  echo "  git push origin v$version"
}
