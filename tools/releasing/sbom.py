#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The list of parts of a release (software bill of materials, CycloneDX 1.6, JSON), validated against its schema.

    sbom.py RELEASE-FOLDER VERSION COMMIT SECONDS SITE-PACKAGES      prints it; SECONDS: of the commit, since 1970

The products of the release, the parts of third_party.toml that are in them, and the Python packages that pip installs beside
our wheels (python_packages.py).
"""

import datetime
import hashlib
import pathlib
import uuid
from importlib.metadata import Distribution

from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.model import HashAlgorithm, HashType
from cyclonedx.model.bom import Bom, BomMetaData
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.output.json import JsonV1Dot6
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packageurl import PackageURL
from packaging.utils import canonicalize_name

import parts
import python_packages
from errors import ReleaseError, run

LICENCE = LicenseFactory().make_with_expression("Apache-2.0")
PRODUCTS = {
    "image": ("*.bin", ComponentType.FIRMWARE),
    "programs": ("trackservo-programs-*", ComponentType.APPLICATION),
    "emulator": ("trackservo-emulator-*", ComponentType.APPLICATION),
    "identify": ("trackservo_identify-*.whl", ComponentType.APPLICATION),
    "servoctl": ("servoctl-*.whl", ComponentType.APPLICATION),
    "imager": ("trackservo_imager-*.whl", ComponentType.APPLICATION),
}
"""Files in the release, and what kind of thing they are."""


def product(name: str, version: str, folder: pathlib.Path) -> list[Component]:
    """One component for each of its files: an image for each board."""
    pattern, kind = PRODUCTS[name]
    files = sorted(folder.glob(pattern))
    if not files:
        raise ReleaseError(f"{folder} has no file {pattern}.")
    return [
        Component(
            name=file.name, version=version, type=kind, bom_ref=f"{name}:{file.name}", licenses=[LICENCE],
            hashes=[HashType(alg=HashAlgorithm.SHA_256, content=hashlib.sha256(file.read_bytes()).hexdigest())],
        )
        for file in files
    ]  # fmt: skip


def third_party(part: parts.Part) -> Component:
    """A part within our files."""
    kind, name = part.purl
    purl = PackageURL(kind, "debian" if kind == "deb" else None, name, part.version)
    licence = LicenseFactory().make_with_expression(part.licence)
    return Component(name=part.name, version=part.version, bom_ref=str(purl), purl=purl, licenses=[licence])


def python_package(found: Distribution) -> Component:
    """One that pip installs."""
    name = found.metadata["Name"]
    purl = PackageURL("pypi", None, canonicalize_name(name), found.version)
    stated = found.metadata.json.get("license_expression")
    licences = [LicenseFactory().make_with_expression(str(stated))] if stated else []
    return Component(name=name, version=found.version, bom_ref=str(purl), purl=purl, licenses=licences)


def bill(folder: pathlib.Path, version: str, commit: str, seconds: int, site: pathlib.Path) -> Bom:
    """The same for the same release: its number is made of version and commit."""
    whole = Component(name="trackservo", version=version, type=ComponentType.APPLICATION, bom_ref="trackservo", licenses=[LICENCE])
    bom = Bom(
        serial_number=uuid.uuid5(uuid.NAMESPACE_OID, f"trackservo {version} {commit}"),
        metadata=BomMetaData(
            timestamp=datetime.datetime.fromtimestamp(seconds, datetime.UTC),
            component=whole,
        ),
    )
    products = {name: product(name, version, folder) for name in PRODUCTS}
    within = {name: [third_party(part) for part in parts.all_parts() if name in part.within] for name in PRODUCTS}
    for name in ("servoctl", "imager"):
        wheels = [next(folder.glob(PRODUCTS[wheel][0])) for wheel in ("servoctl", name)]
        within[name] += map(python_package, python_packages.closure(site, wheels).values())
    within["imager"] += products["servoctl"]
    for name, components in products.items():
        bom.components.update(components, within[name])
        for component in components:
            bom.register_dependency(component, within[name])
    bom.register_dependency(whole, [each for components in products.values() for each in components])
    return bom


def main(arguments: list[str]) -> None:
    if len(arguments) != 5:
        raise ReleaseError(str(__doc__))
    folder, version, commit, seconds, site = arguments
    bom = bill(pathlib.Path(folder), version, commit, int(seconds), pathlib.Path(site))
    text = JsonV1Dot6(bom).output_as_string(indent=1)
    wrong = JsonStrictValidator(SchemaVersion.V1_6).validate_str(text)
    if wrong is not None:
        raise ReleaseError(f"the list of parts is no CycloneDX 1.6: {wrong}")
    print(text)


if __name__ == "__main__":
    run(main)
