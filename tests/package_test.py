#!/usr/bin/env python3
"""CTest `package`: the Debian packages contain what belongs in them, each file once.

    package_test.py BUILD

Does nothing without dpkg-deb and dpkg-shlibdeps.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

# package: files that it must contain, endings of names that it must not contain
WANTED = {
    "orient": ({"usr/bin/orient", "usr/share/man/man1/orient.1.gz",
                "usr/share/man/man1/orient-block.1.gz", "usr/share/doc/orient/block.md",
                "usr/share/doc/orient/copyright", "usr/share/doc/orient/changelog.gz",
                "usr/share/orient/cameras/wild_rc10.toml",
                "usr/share/bash-completion/completions/orient",
                "usr/share/zsh/vendor-completions/_orient"}, (".h", ".a", ".cmake")),
    "liborient-dev": ({"usr/include/orient/block/block.h", "usr/lib/liborient_block.a",
                       "usr/lib/cmake/orient/orient-config.cmake",
                       "usr/share/doc/liborient-dev/copyright"}, (".md", ".toml", ".1.gz")),
    "python3-orient": ({"usr/lib/python3/dist-packages/orient/__init__.py",
                        "usr/lib/python3/dist-packages/orient/_native.pyi",
                        "usr/lib/python3/dist-packages/orient/py.typed",
                        "usr/share/doc/python3-orient/copyright"}, (".h", ".a", ".md", ".1.gz")),
}
# Libraries that the program is linked with are detected; those that the headers need are listed.
DEPENDS = {"orient": ("libgdal", "libopencv-core", "libc6"),
           "liborient-dev": ("libeigen3-dev", "libceres-dev", "libtomlplusplus-dev", "libdeflate-dev",
                             "libspng-dev"),
           "python3-orient": ("python3-numpy", "libgdal", "orient (=")}


def output_of(*words):
    return subprocess.run([str(word) for word in words], check=True, capture_output=True,
                          text=True).stdout


def complaints_about(package, files, depends):
    wanted, unwanted = WANTED[package]
    found = [f"{package}: {name} is missing" for name in sorted(wanted - files)]
    found += [f"{package}: {name} does not belong there" for name in sorted(files)
              if name.endswith(unwanted)]
    return found + [f"{package}: does not depend on {name}: {depends}"
                    for name in DEPENDS[package] if name not in depends]


def main(build):
    if not all(map(shutil.which, ("dpkg-deb", "dpkg-shlibdeps"))):
        print("dpkg-dev is not installed: no packages are made")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        output_of("cpack", "--config", f"{build}/CPackConfig.cmake", "-B", folder)
        packages = {deb.name.partition("_")[0]: deb for deb in pathlib.Path(folder).glob("*.deb")}
        found = [] if packages.keys() == WANTED.keys() else [f"made were {sorted(packages)}"]
        seen = set()
        for package in packages.keys() & WANTED.keys():
            listed = output_of("dpkg-deb", "-c", packages[package])
            files = {line.split()[5][2:] for line in listed.splitlines() if line[0] != "d"}
            found += complaints_about(package, files,
                                      output_of("dpkg-deb", "-f", packages[package], "Depends"))
            found += [f"{name} is in two packages" for name in sorted(files & seen)]
            seen |= files
    print("\n".join(found) or "the packages are whole")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) == 2 else __doc__)
