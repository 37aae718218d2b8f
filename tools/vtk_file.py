"""Arrays of the VTK XML files that quoin writes: raw appended data, little-endian, UInt64 sizes."""
import struct
import xml.etree.ElementTree as xml

CODES = {"Float64": "d", "Int64": "q", "Int32": "i", "UInt8": "B"}
MARK = b'<AppendedData encoding="raw">\n_'


def read(path):
    """(attributes of the piece, {name: list of numbers, tuples or texts}) of a .vtu or .vtp file."""
    content = path.read_bytes()
    head, data = content.split(MARK, 1)
    root = xml.fromstring(head.decode() + "</VTKFile>")
    piece = root.find(".//Piece")
    arrays = {}
    for node in [*piece.iter("DataArray"), *piece.iter("Array")]:
        offset = int(node.get("offset"))
        size, = struct.unpack_from("<Q", data, offset)
        raw = data[offset + 8:offset + 8 + size]
        if node.get("type") == "String":
            values = raw.decode().split("\0")[:-1]
        else:
            values = [v[0] for v in struct.iter_unpack("<" + CODES[node.get("type")], raw)]
            components = int(node.get("NumberOfComponents"))
            if components > 1:
                values = list(zip(*[iter(values)] * components))
        arrays[node.get("Name")] = values
    return piece.attrib, arrays
