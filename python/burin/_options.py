"""Every option of a run by the names of the command line (docs/options.md)."""

from burin import _burin


class _Group:
    """The options GROUP.*, as attributes."""

    def __init__(self, options, name):
        object.__setattr__(self, "_options", options)
        object.__setattr__(self, "_name", name)

    def __getattr__(self, field):
        try:
            return self._options[f"{self._name}.{field}"]
        except KeyError as error:
            raise AttributeError(error.args[0]) from None

    def __setattr__(self, field, value):
        try:
            self._options[f"{self._name}.{field}"] = value
        except KeyError as error:
            raise AttributeError(error.args[0]) from None

    def __dir__(self):
        prefix = self._name + "."
        return [name[len(prefix):] for name in self._options if name.startswith(prefix)]

    def __repr__(self):
        fields = ", ".join(f"{field}={getattr(self, field)!r}" for field in dir(self))
        return f"{self._name}({fields})"


class Options:
    """Options with the defaults of the command line, or of a dict {"group.field": value}.

    options.level.rounds and options["level.rounds"] are the same option. A value of another type
    raises TypeError, one out of range InputError, a name that does not exist AttributeError or
    KeyError; the option then keeps its value.
    """

    def __init__(self, values=()):
        object.__setattr__(self, "_native", _burin.Options())
        for name, value in dict(values).items():
            self[name] = value

    def __getitem__(self, name):
        return self._native.get(name)

    def __setitem__(self, name, value):
        self._native.set(name, value)

    def __iter__(self):
        return iter(self._native.names())

    def __len__(self):
        return len(self._native.names())

    def __getattr__(self, group):
        if not group.startswith("_") and any(name.startswith(group + ".") for name in self):
            return _Group(self, group)
        raise AttributeError(f"{group}: there is no option group of this name")

    def __setattr__(self, name, value):
        raise AttributeError(f"{name}: options are set as options.GROUP.FIELD = VALUE")

    def __dir__(self):
        return sorted({name.split(".")[0] for name in self} | set(object.__dir__(self)))

    def __eq__(self, other):
        return isinstance(other, Options) and self.to_dict() == other.to_dict()

    __hash__ = None

    def __repr__(self):
        defaults = Options().to_dict()
        changed = {name: value for name, value in self.to_dict().items() if value != defaults[name]}
        return f"Options({changed!r})"

    def __copy__(self):
        return Options(self.to_dict())

    def __deepcopy__(self, memo):
        return Options(self.to_dict())

    def __reduce__(self):
        return Options, (self.to_dict(),)

    def to_dict(self):
        """{"group.field": value} of all options, which Options() takes."""
        return {name: self[name] for name in self}

    def help(self, name):
        """One line on the option, and what values it takes."""
        return f"{self._native.help(name)} ({self._native.constraint(name)})"


def as_options(options):
    """Options of None (the defaults), of a dict, or the Options given."""
    if isinstance(options, Options):
        return options
    return Options() if options is None else Options(options)
