# finish.sh STAGE RELEASE DATE MAINTAINER VERSION: makes of an installed tree what Debian expects of a package: its copyright
# file, packed changelogs and manual, permissions. All files get the release's date, so that the same sources give the same bytes.
stage=$1 release=$2 date=$3 maintainer=$4 version=$5
doc=$stage/usr/share/doc/slipdisk

rm -f "$doc/LICENSE"
cp tools/packaging/debian/copyright "$doc/copyright"
cp docs/changelog.md "$doc/changelog"
cat >"$doc/changelog.Debian" <<END
slipdisk ($version-$release) unstable; urgency=medium

  * Version $version; changelog.gz tells what is new.

 -- $maintainer  $(LC_ALL=C date -u -d "$date" '+%a, %d %b %Y %H:%M:%S +0000')
END
mkdir -p "$stage/usr/share/lintian/overrides"
cp tools/packaging/debian/lintian-overrides "$stage/usr/share/lintian/overrides/slipdisk"

# Scripts of the site that Debian has a package of.
static=$doc/html/_static shared=/usr/share/javascript/sphinxdoc/1.0
for file in "$static"/*.js; do
  if cmp -s "$file" "$shared/${file##*/}"; then ln -sf "../../../../javascript/sphinxdoc/1.0/${file##*/}" "$file"; fi
done

gzip -9n "$doc/changelog" "$doc/changelog.Debian" "$stage"/usr/share/man/man1/*.1
find "$stage/usr" -name __pycache__ -prune -exec rm -r {} +
find "$stage/usr" -type d -exec chmod 755 {} +
find "$stage/usr" -type f ! -path '*/bin/*' -exec chmod 644 {} +
find "$stage" -exec touch -h -d "$date UTC" {} +
