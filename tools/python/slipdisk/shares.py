"""Files of which each rank of a run has written a share: put together in memory. What is in a share: src/io/store/h5.h."""
import re

import h5py
import numpy as np

KEPT = "unit", "description"


def datasets(group):
    """Path below the group -> dataset."""
    found = {}
    group.visititems(lambda name, item: found.update({name: item}) if isinstance(item, h5py.Dataset) else None)
    return found


def join(head, shares, group):
    """Datasets of the shares' group become those of the head, ordered by keys; what the head has itself stands behind."""
    rows = [len(share[group]["key"]) for share in shares]
    order = np.argsort(np.concatenate([share[group]["key"][:] for share in shares]), kind="stable")
    each = int(shares[0][group]["key"].attrs.get("each", 0))
    found = [datasets(share[group]) for share in shares]
    for path, like in found[int(np.argmax(rows))].items():
        if path == "key":
            continue
        data = np.concatenate([pieces[path][:] for pieces, n in zip(found, rows) if n] or [like[:]])[order]
        if each:
            data = data.reshape(-1, each, *data.shape[1:])
        notes = {name: like.attrs[name] for name in KEPT if name in like.attrs}
        if path in head:
            notes.update({name: head[path].attrs[name] for name in KEPT if name in head[path].attrs})
            if not each:  # rows of several numbers stand one after the other, as in a file without shares
                data = np.concatenate([data.reshape(-1, *head[path].shape[1:]), head[path][:]])
            del head[path]
        head.create_dataset(path, data=data).attrs.update(notes)
        element = path.removesuffix("/value")
        for clock in ("step", "time") if element != path else ():  # all elements of frames have the same
            if f"{element}/{clock}" not in head:
                head[f"{element}/{clock}"] = head[f"particles/disks/position/{clock}"]


def opened(path):
    """An open file; one with shares is a copy in memory that has all of them."""
    file = h5py.File(path, "r")
    if "shares" not in file:
        return file
    with file:
        head = h5py.File(f"{path} in memory", "w", driver="core", backing_store=False)
        head.attrs.update(file.attrs)
        for name in file:
            file.copy(name, head)
        shares = [h5py.File(re.sub(r"(\.h5)?$", f"-{k}.h5", path, count=1), "r") for k in range(len(file["shares"]))]
    try:
        for group in "disks", "contacts":
            join(head, shares, group)
    finally:
        for share in shares:
            share.close()
    return head
