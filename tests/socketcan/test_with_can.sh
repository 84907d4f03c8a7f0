#!/usr/bin/env bash
# Proves the promises of with-can in both modes: in User Mode Linux, and in a kernel that has vcan (User Mode Linux's
# own). Needs can-utils, and a Python with python-can: PYTHON, or else that of build/venv.
# shellcheck disable=SC2016  # the single-quoted scripts are for the shells inside
set -uo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
with_can="$here/with-can"
python="${PYTHON:-$here/../../build/venv/bin/python}"
work="$(mktemp -d /tmp/test-with-can.XXXXXX)"
trap 'rm -rf "$work"' EXIT
out="$work/out"
err="$work/err"
# A PATH whose first folder has a compiler that fails.
mkdir "$work/no_cc"
printf '#!/bin/sh\nexit 1\n' >"$work/no_cc/cc"
chmod +x "$work/no_cc/cc"
passed=0
left_out=0
failed=0

uml() {
  "$with_can" --via uml "$@"
}

# check NAME COMMAND...: the test passes when the command succeeds.
check() {
  local name="$1"
  shift
  if "$@"; then
    passed=$((passed + 1))
    echo "ok    $name"
  else
    failed=$((failed + 1))
    echo "FAIL  $name"
    [[ ! -s "$out" ]] || head -n 10 "$out" | sed 's/^/      out: /'
    [[ ! -s "$err" ]] || head -n 10 "$err" | sed 's/^/      err: /'
  fi
}

# gives CODE COMMAND...: keeps the command's output in $out and $err.
gives() {
  local wanted="$1" code=0
  shift
  "$@" >"$out" 2>"$err" || code=$?
  [[ "$code" == "$wanted" ]] || {
    echo "      exit code $code instead of $wanted"
    return 1
  }
}

# Succeeds if $1 (out or err) is exactly $2.
prints() {
  cmp --silent "$work/$1" <(printf '%s' "$2")
}

# The folder of the run whose command contains $1.
job_of() {
  local file
  file="$(grep --files-with-matches --text --fixed-strings "$1" \
    {/dev/shm,/tmp,/var/tmp}/with-can.*/command 2>/dev/null)"
  echo "${file%/command}"
}

exit_codes() {
  gives 0 uml true && gives 1 uml false && gives 7 uml sh -c 'exit 7'
}

no_command() {
  gives 127 uml no-such-command && grep -q no-such-command "$err" && gives 126 uml /etc/passwd && gives 125 uml
}

clean_streams() {
  gives 3 uml sh -c 'echo out; echo err >&2; cat; exit 3' && prints out $'out\n' && prints err $'err\n'
}

order_in_one_stream() {
  gives 0 sh -c '"$@" 2>&1' sh "$with_can" --via uml sh -c 'for n in 1 2 3; do echo "o$n"; echo "e$n" >&2; done' &&
    prints out $'o1\ne1\no2\ne2\no3\ne3\n'
}

can_utils() {
  gives 0 uml bash -c 'candump -n 1 -T 10000 vcan0 & sleep 0.5; cansend vcan0 123#DEADBEEF; wait' &&
    grep -Eq 'vcan0 +123 +\[4\] +DE AD BE EF' "$out"
}

python_can() {
  cat >"$work/two_buses.py" <<'PYTHON'
import socket
import can

with can.Bus("vcan0", interface="socketcan") as one, can.Bus("vcan0", interface="socketcan") as two:
    one.send(can.Message(arbitration_id=0x601, data=[0x40, 0, 0x10, 0], is_extended_id=False))
    message = two.recv(10)
    assert message.arbitration_id == 0x601 and bytes(message.data) == b"\x40\x00\x10\x00", message
    two.send(can.Message(arbitration_id=0x581, data=bytes(8), is_extended_id=False))
    assert one.recv(10).arbitration_id == 0x581
    task = one.send_periodic(can.Message(arbitration_id=0x80, is_extended_id=False), 0.01)
    assert [two.recv(10).arbitration_id for _ in range(3)] == [0x80] * 3
    task.stop()
server = socket.create_server(("127.0.0.1", 0))
socket.create_connection(server.getsockname()).sendall(b"x")
assert server.accept()[0].recv(1) == b"x"
print("both ways")
PYTHON
  gives 0 uml "$python" "$work/two_buses.py" && prints out $'both ways\n'
}

# Nothing of the run marked $1 is left, after a short time for the machine to remove ended processes.
nothing_left() {
  local job="$1" try
  for try in {1..50}; do
    if [[ ! -e "$job" ]] && ! pgrep -f -- "$job/" >/dev/null; then
      return 0
    fi
    sleep 0.1
  done
  echo "      still there after $try tries: $job"
  return 1
}

time_limit() {
  local started=$SECONDS job="" run
  "$with_can" --via uml --timeout 2 sh -c 'trap "" TERM; echo begun; sleep 1001; sleep 1001' >"$out" 2>"$err" &
  run=$!
  until [[ -n "$job" ]] || ! kill -0 "$run" 2>/dev/null; do
    job="$(job_of 'sleep 1001')"
  done
  gives_code_of "$run" 124 && prints out $'begun\n' && grep -q 'terminated after 2 s' "$err" &&
    ((SECONDS - started < 30)) && [[ -n "$job" ]] && nothing_left "$job"
}

gives_code_of() {
  local code=0
  wait "$1" 2>/dev/null || code=$?
  [[ "$code" == "$2" ]]
}

# killed SIGNAL CODE: with-can ends at once and leaves nothing.
killed() {
  local run job
  : >"$out"
  "$with_can" --via uml sh -c "echo begun; sleep 1002; : $1" >"$out" 2>"$err" &
  run=$!
  until grep -q begun "$out" || ! kill -0 "$run" 2>/dev/null; do
    sleep 0.1
  done
  job="$(job_of ": $1")"
  kill "-$1" "$run"
  gives_code_of "$run" "$2" && [[ -n "$job" ]] && nothing_left "$job"
}

side_by_side() {
  local script='candump -T 3000 vcan0 & sleep 1; cansend vcan0 "$1"; wait' first code=0
  uml bash -c "$script" - 111#11 >"$work/first" 2>&1 &
  first=$!
  gives 0 uml bash -c "$script" - 222#22 || code=1
  wait "$first" && grep -q ' 111 ' "$work/first" && ! grep -q ' 222 ' "$work/first" && grep -q ' 222 ' "$out" &&
    ! grep -q ' 111 ' "$out" && [[ "$code" == 0 ]]
}

words_and_folders() {
  local folder="$work/a folder  with 'spaces'"
  mkdir -p "$folder"
  cd "$folder" || return 1
  MARK=$'two\nlines' gives 0 "$with_can" --via uml sh -c 'printf "%s|" "$PWD" "$MARK" "$@"; echo kept >file; umask' \
    - 'a  b' '' '"$x"' $'c\nd' && prints out "$folder|"$'two\nlines|a  b||"$x"|c\nd|'"$(umask)"$'\n' &&
    [[ "$(<file)" == kept ]]
}

checkout_with_spaces() {
  cp -r "$here" "$work/my copy" && gives 5 "$work/my copy/with-can" --via uml sh -c 'exit 5'
}

temporary_files() {
  gives 0 uml sh -c 'f="$(mktemp)"; echo x >"$f"; cat "$f"; echo "$f" >&2' && prints out $'x\n' &&
    [[ ! -e "$(<"$err")" ]] && grep -q ^/dev/shm/ "$err"
}

much_output() {
  seq 1 2000000 >"$work/numbers"
  uml seq 1 2000000 | { sleep 4 && cat; } | cmp - "$work/numbers"
}

# The reader of the output closes it.
reader_gone() {
  local started=$SECONDS
  [[ "$(uml yes | head -n 1)" == y ]] && ((SECONDS - started < 30))
}

left_running() {
  local started=$SECONDS
  gives 4 uml bash -c 'sleep 1003 & echo said; exit 4' && prints out $'said\n' && ((SECONDS - started < 30))
}

ordinary_user() {
  local as=()
  mkdir -m 777 "$work/open"
  chmod 755 "$work"
  cp -r "$here" "$work/open/copy"
  [[ "$(id -u)" != 0 ]] || as=(setpriv --reuid 65534 --regid 65534 --clear-groups)
  gives 0 "${as[@]}" "$work/open/copy/with-can" --via uml bash -c '
    cd "$1" && id -u && touch mine && ip link add vcan1 type vcan && ip link set vcan1 up && cansend vcan1 001#' - \
    "$work/open" && [[ "$(<"$out")" == "$(stat -c %u "$work/open/mine")" && "$(<"$out")" != 0 ]]
}

# The kernel of User Mode Linux has vcan: with-can finds that inside, and makes another vcan0 in there.
kernel_way() {
  gives 9 uml "$with_can" bash -c '
    candump -n 1 -T 10000 vcan0 & sleep 0.5; cansend vcan0 077#01; wait; echo "$WITH_CAN"; echo err >&2; exit 9' &&
    grep -Eq 'vcan0 +077 +\[1\] +01' "$out" && grep -q '^kernel$' "$out" && prints err $'err\n'
}

# Registers of 11,008 bytes: without uml_xstate.c User Mode Linux ends, with it floating point and AVX stay right.
more_registers() {
  local large="$work/large_xstate.so"
  cc -shared -fPIC -O1 -o "$large" "$here/large_xstate.c" || return 1
  gives 0 env WITH_CAN_PRELOAD="$large" "$with_can" --via uml "$python" -c \
    'print(sum(0.1 * i for i in range(100)), sum(range(10**6)))' &&
    prints out $'495.0 499999500000\n' &&
    gives 125 env WITH_CAN_PRELOAD="$large" PATH="$work/no_cc:$PATH" "$with_can" --via uml true &&
    grep -q 'ended before the command' "$err"
}

kernel_way_limits() {
  gives 0 uml bash -c '
    "$1" --via kernel --timeout 1 sleep 1004; [[ $? == 124 ]] || exit 1
    "$1" --via kernel no-such-command; [[ $? == 127 ]] || exit 2
    "$1" --via kernel sleep 1005 & run=$!; sleep 1; kill -KILL "$run"
    for second in {1..20}; do sleep 1; pgrep -fx "sleep 1005" >/dev/null || break; done
    ! pgrep -fx "sleep 1005" || exit 3
    [[ "$(ip -o link | wc -l)" == 2 ]] || exit 4
    setpriv --reuid 65534 --regid 65534 --clear-groups "$1" --via kernel --timeout 30 ip link set vcan0 down ||
      exit 5' - "$with_can" && grep -q 'terminated after 1 s' "$err"
}

# In namespaces where folders and programs can be hidden.
masked() {
  local user=()
  [[ "$(id -u)" == 0 ]] || user=(--user --map-root-user)
  unshare "${user[@]}" --mount sh -c "$1"' && shift && exec "$@"' sh "${@:2}"
}

# As check, but reported and left out where the container forbids hiding (no mount namespaces).
check_masked() {
  if masked : true 2>/dev/null; then
    check "$@"
  else
    left_out=$((left_out + 1))
    echo "----  $1: left out, mount namespaces are forbidden here"
  fi
}

read_only_places() {
  gives 6 masked 'mount -o remount,ro,bind / && : "$@"' sh "$with_can" --via uml sh -c 'touch "/tmp/new.$$" || exit 6' &&
    grep -q 'Read-only' "$err"
}

# neither REASON MASK [OPTION...]: one sentence and 125.
neither() {
  local reason="$1" mask="$2"
  shift 2
  gives 125 masked "$mask" sh "$with_can" --via uml "$@" true && prints out '' && grep -q "$reason" "$err"
}

"$python" -c 'import can' || {
  echo "test_with_can.sh: '$python' has no python-can; name one that has in PYTHON." >&2
  exit 1
}

check "exit codes 0, 1 and 7" exit_codes
check "no such command, no executable, no command at all" no_command
check "output and errors apart, nothing of the kernel in them, empty input" clean_streams
check "order is kept where both go to one place" order_in_one_stream
check "candump sees cansend's frame" can_utils
check "python-can sends and receives, cyclically too; TCP on 127.0.0.1" python_can
check "time limit, with a command deaf to SIGTERM" time_limit
check "SIGTERM ends all" killed TERM 143
check "SIGHUP ends all" killed HUP 129
check "SIGKILL ends all" killed KILL 137
check "two runs side by side" side_by_side
check "folder, arguments and environment arrive as they are" words_and_folders
check "a checkout in a folder with spaces" checkout_with_spaces
check "temporary files stay off the host" temporary_files
check "much output, slowly read" much_output
check "nobody reads the output any more" reader_gone
check "a process left behind does not hold the run" left_running
check "an ordinary user, who may make interfaces" ordinary_user
check "kernel with vcan" kernel_way
check "kernel with vcan: time limit, no command, SIGKILL, ordinary user" kernel_way_limits
check "a processor with more registers than User Mode Linux knows" more_registers
check_masked "read-only root" read_only_places
check_masked "no User Mode Linux: one sentence" \
  neither 'linux.uml missing.*install' 'mount --bind /dev/null "$(command -v linux.uml)"'
check_masked "no vcan module: one sentence" \
  neither 'insmod could not insert' 'mount --bind /dev/null "$(find /usr/lib/uml -name vcan.ko)"'
check_masked "User Mode Linux that does not start: its last words" \
  neither 'ended before the command' 'mount --bind /bin/ls "$(command -v linux.uml)"'
check_masked "no room for its memory: one sentence" \
  neither 'needs a folder with 900000 MiB' : --memory 900000

booted="$(date +%s%N)"
uml true
echo "boot, 'true' and power-off: $((($(date +%s%N) - booted) / 1000000)) ms"
echo "$passed passed, $failed failed, $left_out left out"
[[ "$failed" == 0 ]]
