# Turns the machine's own apt entries into entries for source packages.
# In: deb822 stanzas (*.sources, read with RS="") or one-line entries (*.list), distinguished by the file's name.
# -v distribution_uris="uri uri": entries of other archives are left out; empty: all are kept.
# Out: the same entries as deb-src, with their options (Signed-By among them), in the format of the input.

function known(uri, i) {
  sub(/\/+$/, "", uri)
  if (distribution_count == 0) return 1
  for (i = 1; i <= distribution_count; i++) if (distribution[i] == uri) return 1
  return 0
}

BEGIN {
  distribution_count = split(distribution_uris, distribution, /[ \n]+/)
  for (i = 1; i <= distribution_count; i++) sub(/\/+$/, "", distribution[i])
}

format == "list" && $1 == "deb" {
  entry = $0
  sub(/^[ \t]*deb/, "deb-src", entry)
  # The address is the first word after the options in brackets, if there are any.
  address = $0
  sub(/^[ \t]*deb[ \t]+/, "", address)
  sub(/^\[[^]]*\][ \t]*/, "", address)
  sub(/[ \t].*$/, "", address)
  if (known(address)) print entry
}

format == "sources" {
  binary = 0; enabled = 1; wanted = 0; stanza = ""; field = ""
  line_count = split($0, lines, "\n")
  for (i = 1; i <= line_count; i++) {
    line = lines[i]
    if (line ~ /^#/) continue
    if (line !~ /^[ \t]/) { field = tolower(line); sub(/:.*/, "", field) }
    value = line
    sub(/^[^ \t:]*:/, "", value)
    if (field == "types") {
      if (value ~ /(^|[ \t])deb([ \t]|$)/) binary = 1
      continue
    }
    if (field == "architectures") continue
    if (field == "enabled" && tolower(value) ~ /no|false|off|0/) enabled = 0
    if (field == "uris") {
      uri_count = split(value, uris, /[ \t]+/)
      for (j = 1; j <= uri_count; j++) if (uris[j] != "" && known(uris[j])) wanted = 1
    }
    stanza = stanza line "\n"
  }
  if (binary && enabled && wanted) print "Types: deb-src\n" stanza
}
