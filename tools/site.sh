#!/bin/sh
# site.sh: `make site`: README.md, docs/ and the interface from its docstrings as build/site, in .venv-site. A link that
# leads nowhere fails it. A link to a source file becomes its name: the site does not hold the sources. A line that is a
# link to a recorded run shows the run below it.
set -eu
cd "$(dirname "$0")/.."

python=$(tools/find_python.sh "3.10 3.11 3.12 3.13" 2>&1) || {
    echo "site: $python" >&2
    exit 1
}
tools/environment.sh .venv-site "$python" constraints.txt "mkdocs" -r requirements-site.txt

pages=build/site_pages
rm -rf "$pages"
mkdir -p "$pages"
cp -R docs/. "$pages"
sed -E 's#\]\(docs/#](#g; s#\[([^]]*)\]\((LICENSE|[A-Z]+\.(md|cff))\)#\1#g' README.md >"$pages/index.md"
find "$pages" -name '*.md' -exec sed -E -i \
    -e 's#\]\((\.\./)+README\.md#](index.md#g' -e 's#\[([^]]*)\]\((\.\./)+(src|tests|tools|examples|studies|[A-Z]+\.)[^)]*\)#\1#g' \
    -e 's#^\[[^]]*\]\((runs/[a-z]+\.html)\)$#&\n\n<iframe src="../\1" title="a recorded run" style="width: 100%; height: 40rem"></iframe>#' {} +
cat >"$pages/api.md" <<PAGE
# Interface

::: collplan_core

::: collplan_core.planners

::: omnipuck_sim.trial

::: collplan_gym
PAGE
# its makers ask to move to another tool
NO_MKDOCS_2_WARNING=1 .venv-site/bin/python -m mkdocs build --strict
echo "build/site/index.html"
